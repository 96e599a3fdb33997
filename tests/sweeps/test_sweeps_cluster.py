"""Sweeps on the workers of a Dask scheduler: real processes on this machine."""

from __future__ import annotations

import operator
import os
import signal
from functools import partial

import numpy as np
import pytest

import linkages
from linkages.errors import ComputationError, InputError
from linkages.sweeps import places as cluster
from linkages.sweeps.places import Cluster

distributed = pytest.importorskip("distributed", reason="Dask is not installed")
dask = pytest.importorskip("dask")

pytestmark = [pytest.mark.slow_except(), pytest.mark.filterwarnings("ignore")]  # Dask's own

SIZES = {"clearances.r1.size": np.linspace(1e-5, 1e-3, 10)}
PEAK = "max(abs(slider9.velocity))"


@pytest.fixture(scope="module")
def local():
    settings = {"distributed.scheduler.allowed-failures": 1, "distributed.logging": {}}
    with (
        dask.config.set(settings),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as found,
    ):
        yield found


def swept(**options):
    ninebar = linkages.load("ninebar")
    return linkages.sweep(ninebar, SIZES, PEAK, end=0.2, **options)


def test_a_worker_that_is_killed_changes_nothing(local, tmp_path):
    with distributed.Client(local, set_as_default=False) as client:
        pids = list(client.run(os.getpid).values())
    killed = []

    def watch(progress):
        if not killed:
            killed.append(progress.done)
            os.kill(pids[0], signal.SIGKILL)

    found = swept(scheduler=local.scheduler_address, watch=watch, store=tmp_path / "sweep")
    assert killed
    assert killed[0] < 10
    assert found.identical(swept())
    again = swept(store=tmp_path / "sweep", scheduler="tcp://127.0.0.1:1")
    assert again.identical(found)


def test_a_chunk_that_ends_its_workers_has_that_as_its_reason(local):
    points = [os.getpid, partial(os._exit, 1)]
    run = Cluster(local.scheduler_address).run(operator.call, points)
    first, second = sorted(run, key=lambda outcome: outcome.index)
    assert first.reason is None
    assert first.value != os.getpid()
    assert second.reason == "ended every worker that computed it"


def test_workers_of_another_version_compute_nothing(local, monkeypatch):
    monkeypatch.setattr(cluster, "here", lambda: "linkages 0.0 (kernels 1)")
    with pytest.raises(ComputationError, match=r"a worker has linkages .*; expected linkages 0\.0"):
        swept(scheduler=local.scheduler_address)


@pytest.mark.slow_except("*")
def test_nobody_answers(monkeypatch):
    monkeypatch.setattr(cluster, "CONNECTING", 1)
    with pytest.raises(InputError, match=r"tcp://127\.0\.0\.1:1: no Dask scheduler answers there"):
        swept(scheduler="tcp://127.0.0.1:1")


@pytest.mark.slow_except("*")
def test_cores_and_scheduler_contradict_each_other():
    with pytest.raises(ValueError, match="expected one of them"):
        swept(scheduler="tcp://127.0.0.1:1", cores=2)
