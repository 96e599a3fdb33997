"""How many threads a sweep takes: as many as the process may use, not as the machine has."""

import os
import threading

import pytest

from linkages.sweeps import running as cores
from linkages.sweeps.running import Threads, available_cores, quota


def test_a_sweep_takes_the_cores_that_it_may_use(monkeypatch):
    monkeypatch.setattr(os, "process_cpu_count", lambda: 3, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    monkeypatch.setattr(cores, "quota", lambda: None)
    assert Threads().workers == 3
    monkeypatch.setattr(cores, "quota", lambda: 2)
    assert Threads().workers == 2
    assert Threads(5).workers == 5


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no affinity on this system")
def test_affinity_counts():
    allowed = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(allowed)})
        assert available_cores() == 1
    finally:
        os.sched_setaffinity(0, allowed)


@pytest.mark.parametrize(
    ("inner", "outer", "expected"),
    [("150000 100000", "max 100000", 2), ("max 100000", "400000 100000", 4),
     ("50000 100000", "400000 100000", 1), ("max 100000", "max 100000", None)],
)  # fmt: skip
def test_quotas_of_control_groups_are_rounded_up(tmp_path, inner, outer, expected):
    group = tmp_path / "cgroup" / "slurm" / "job"
    group.mkdir(parents=True)
    (group / "cpu.max").write_text(inner + "\n")
    (group.parent / "cpu.max").write_text(outer + "\n")
    own = tmp_path / "self"
    own.write_text("4:memory:/elsewhere\n0::/slurm/job\n")
    assert quota(tmp_path / "cgroup", own) == expected


def test_without_control_groups_there_is_no_quota(tmp_path):
    assert quota(tmp_path, tmp_path / "missing") is None


def test_the_first_point_does_not_run_alone():
    """Both wait for each other: one after the other they would never end."""
    meeting = threading.Barrier(2, timeout=60)
    outcomes = Threads(2).run(lambda value: (meeting.wait(), value)[1], [1, 2])
    assert sorted(outcome.value for outcome in outcomes) == [1, 2]
