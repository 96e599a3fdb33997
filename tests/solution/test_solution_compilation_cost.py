"""What is said of long computations before they begin."""

from __future__ import annotations

import logging
import subprocess
import sys

import pytest
import yaml

import linkages
from linkages.kernel import system as systems
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.system import System
from linkages.solution import plan
from linkages.solution.plan import Plan, expected_seconds, expected_terms, kernel_source
from linkages.topology import topology as topologies


def bars(count, start):
    """Free bars, each of which hangs from where `start` of its number says."""
    return {
        "gravity": [0, -9.81],
        "joints": {"J0": [0, 0]},
        "bars": {
            f"b{i}": {"joints": [f"J{start(i)}", f"J{i + 1}"], "length": 0.1, "mass": 1}
            for i in range(count)
        },
        "free": {f"b{i}": {"angle": 0.1 * i, "speed": 0} for i in range(count)},
    }


SHAPES = {"row": lambda i: i, "star": lambda _: 0, "pairs": lambda i: i if i % 2 else 0}


def made(count, shape):
    return linkages.loads(yaml.safe_dump(bars(count, SHAPES[shape]), sort_keys=False))


@pytest.mark.parametrize("few", [1, 1000])
@pytest.mark.parametrize("shape", SHAPES)
def test_terms_are_about_as_many_as_expected(shape, few, monkeypatch):
    """Both ways of elimination, bars that all move each other, and bars that do not.

    Within a factor of 2: seconds are rounded, and differ as much between machines.
    """
    monkeypatch.setattr(topologies, "FEW", few)
    topology = System(made(24, shape)).topology
    found = len(kernel_source(topology).model.graph.nodes)
    assert 0.5 < found / expected_terms(topology) < 2


def test_dyads_move_with_the_coordinates_of_what_they_hang_from():
    cranks = linkages.load("four-bar")
    assert expected_terms(System(cranks).topology) < 1000  # no coordinate at all, or one


def test_what_takes_long_is_said_before_it_begins(monkeypatch, caplog):
    """Not of what begins soon; and nothing has been compiled by then."""
    for module, name in ((systems, "_STRUCTURES"), (plan, "_PLANS"), (plan, "_FURTHER")):
        monkeypatch.setattr(module, name, LRUCache(8))
    system = System(made(3, "row"))
    with caplog.at_level(logging.WARNING):
        Plan.of(system)
    assert not caplog.messages
    terms = expected_terms(system.topology)
    monkeypatch.setattr(plan, "PATIENCE", 0.9 * expected_seconds(5 * terms))
    monkeypatch.setattr(plan, "kernel_source", lambda *_: pytest.fail("it has begun"))
    with pytest.raises(pytest.fail.Exception), caplog.at_level(logging.WARNING):
        Plan.of(system, tangents=2)
    (said,) = caplog.messages
    assert "equations of motion of 3 free coordinates: about" in said
    assert "s to generate and compile" in said


def test_derivatives_of_implicit_methods_are_announced(monkeypatch, caplog):
    for module, name in ((systems, "_STRUCTURES"), (plan, "_PLANS"), (plan, "_FURTHER")):
        monkeypatch.setattr(module, name, LRUCache(8))
    monkeypatch.setattr(plan, "PATIENCE", 0.005 + expected_seconds(2000))
    with caplog.at_level(logging.WARNING):
        linkages.simulate(made(3, "row"), end=0.01, samples=2, method="radau")
    assert any("derivatives of accelerations by 6 coordinates" in m for m in caplog.messages)


def test_commands_show_it(tmp_path):
    file = tmp_path / "row.yaml"
    definition = bars(3, SHAPES["row"]) | {"simulate": {"end": 0.1, "samples": 3}}
    file.write_text(yaml.safe_dump(definition, sort_keys=False), encoding="utf-8")
    program = (
        "import sys; from linkages.solution import plan; plan.PATIENCE = 0.0; "
        "from linkages.cli.main import main; main()"
    )
    words = ["simulate", str(file), "--out", str(tmp_path / "out"), "--no-figures", "--json"]
    command = [sys.executable, "-c", program, *words]
    result = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "free coordinates: about" in result.stderr
