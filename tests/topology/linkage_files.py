"""The linkages that the tests of this folder analyse."""

from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import pytest

import linkages
from linkages.components.mechanisms.definition import load
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.topology.topology import build_topology

FOLDER = Path(__file__).parents[1] / "data" / "linkages"
NAMES = sorted(file.stem for file in FOLDER.glob("*.yaml"))
FOUR_BAR = """\
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
"""


def linkage(name: str, **numbers: object) -> Mechanism:
    return load(FOLDER / f"{name}.yaml", set=numbers or None)


def mechanism(text: str) -> Mechanism:
    return linkages.loads(text)


def refusal(text: str, analyse: Callable[[Mechanism], object] = build_topology) -> list[str]:
    """What `build_topology`, or something else, finds wrong with a definition."""
    with pytest.raises(InputError) as caught:
        analyse(mechanism(text))
    assert caught.value.exit_code == 2
    return [str(problem) for problem in caught.value.problems]


def truss(levels: int) -> str:
    """A definition of `levels` triangles on a driven crank, each a dyad on the one before."""
    joints = [f"J{i}" for i in range(levels + 2)]
    bars = [
        f"  b{i}{j}: {{joints: [{joints[i]}, {joints[j]}], length: 1}}"
        for i, j in combinations(range(levels + 2), 2)
        if j - i <= 2 and (i, j) != (0, 1)
    ]
    return "joints: {J0: [0, 0]}\nbars:\n  b01: {joints: [J0, J1], length: 1}\n" + "\n".join(bars)
