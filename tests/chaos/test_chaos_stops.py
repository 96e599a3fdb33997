"""Sections and exponents say truly why they stop, and end where they were told to."""

import pytest

import linkages
from linkages.components.definition import from_document
from linkages.errors import ComputationError
from linkages.reading.document import parse

THROWN = """\
name: Thrown four-bar
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 0.06, mass: 0.5}
  coupler: {joints: [A, B], length: 0.07, mass: 0.5}
  rocker: {joints: [D, B], length: 0.05, mass: 0.5}
assembly: {A: [0.04, 0.04], B: [0.1, 0.05]}
free: {crank: {angle: 50 deg, speed: 6}}
simulate: {end: 0.5, samples: 11, rtol: 1e-10}
"""

PARALLELOGRAM = """\
name: Parallelogram
joints: {O: [0, 0], D: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.5}
  coupler: {joints: [A, B], length: 0.1, mass: 0.5}
  rocker: {joints: [D, B], length: 0.04, mass: 0.5}
assembly: {A: [0.02, 0.034], B: [0.12, 0.034]}
free: {crank: {angle: 60 deg, speed: 6}}
simulate: {end: 2, rtol: 1e-10}
"""


def built(text):
    return from_document(parse(text, "linkage.yaml"))


def section(mechanism):
    return linkages.poincare(mechanism, periods=10, section="coupler.speed=7")


def exponents(mechanism):
    return linkages.lyapunov(mechanism, periods=40, interval=0.5)


@pytest.mark.parametrize("analysis", [section, exponents])
def test_a_bad_choice_of_coordinates_is_called_that(analysis):
    """The crank turns back where coupler and rocker are in line; nothing is singular there."""
    mechanism = built(THROWN)
    (note, *_) = linkages.simulate(mechanism).notes
    assert "crank was exchanged for coupler" in note  # what goes on is said by another road
    with pytest.raises(ComputationError) as caught:
        analysis(mechanism)
    text = str(caught.value)
    for words in ("t = 0.3523334", "coupler and rocker are in line", "Name coupler under free",
                  "coupler or rocker could be free instead of crank"):  # fmt: skip
        assert words in text
    assert "two ways" not in text


@pytest.mark.parametrize("analysis", [section, exponents])
def test_a_change_point_is_called_that(analysis):
    """All bars of a parallelogram are in line: every choice of coordinates is singular."""
    with pytest.raises(ComputationError) as caught:
        analysis(built(PARALLELOGRAM))
    assert "can go on in two ways" in str(caught.value)
    assert "could be free" not in str(caught.value)


@pytest.mark.parametrize("budget", [40, 2000])
def test_the_allowed_steps_end_a_run(budget):
    """The second budget lasts for some hundred intervals, so that all of them share one."""
    arm = linkages.load("double-pendulum")
    name = next(iter(arm.bodies))
    for analysis in (
        lambda: linkages.poincare(arm, periods=999, section=f"{name}.speed=0", max_steps=budget),
        lambda: linkages.lyapunov(arm, periods=999, interval=1.0, max_steps=budget),
    ):
        with pytest.raises(ComputationError, match="Raise max_steps"):
            analysis()


def test_steps_must_be_allowed():
    for analysis in (linkages.poincare, linkages.lyapunov):
        with pytest.raises(ValueError, match="max_steps must be at least 1"):
            analysis(linkages.load("ninebar"), max_steps=0)
