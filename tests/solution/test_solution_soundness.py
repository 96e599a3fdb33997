"""Numbers that double precision cannot hold: an error or a stop with its quantity."""

import numpy as np
import pytest

import linkages
from linkages.errors import InputError
from linkages.solution.solution import IncompleteError

CRANK = (
    "joints: {{O: [0, 0]}}\nbars: {{crank: {{joints: [O, A], length: {length}, mass: {mass}}}}}\n"
    "gravity: [0, -9.81]\ndrives: {{crank: {{angle: 0, speed: {speed}}}}}\nsimulate: {{end: 1}}\n"
)


@pytest.mark.parametrize("outputs", [["drive_effort", "joint_position"], "all"])
def test_an_effort_that_overflows_is_a_stop_that_names_it(outputs):
    """A crank of 1e300 kg that is 1e10 m long: its weight has a moment of 5e310 N m."""
    with pytest.raises(IncompleteError) as caught:
        linkages.simulate(
            linkages.loads(CRANK.format(length=1e10, mass=1e300, speed=0)), outputs=outputs
        )
    assert str(caught.value).startswith("at t = 0 s: the driving torque of crank is not a finite")
    assert "numbers from 1e-308 to 1e308" in str(caught.value)
    assert caught.value.time == 0.0
    assert caught.value.solution.data.sizes["time"] == 0


def test_what_was_finite_before_is_kept():
    """θ = exp(300 t) of a bar of 1/3 kg m²: ω²/6 exceeds 1.8e308 from t = 1.167 s on."""
    text = CRANK.format(length=1, mass=1, speed=0).replace("angle: 0, speed: 0", "law: exp(300*t)")
    with pytest.raises(
        IncompleteError, match=r"at t = 1\.2 s: the kinetic energy is not a fin"
    ) as e:
        linkages.simulate(linkages.loads(text), outputs=["kinetic_energy"], end=2.0, samples=21)
    data = e.value.solution.data
    assert data.time.to_numpy() == pytest.approx(np.arange(12) / 10, abs=1e-15)
    rate = 300 * np.exp(300 * data.time)
    assert data.kinetic_energy.to_numpy() == pytest.approx(rate.to_numpy() ** 2 / 6, rel=1e-12)


def test_an_energy_that_overflows():
    mechanism = linkages.loads(CRANK.format(length=1e100, mass=1, speed=1e100))
    with pytest.raises(IncompleteError, match="kinetic energy is not a finite number"):
        linkages.simulate(mechanism, outputs=["kinetic_energy"], end=1e-100)


@pytest.mark.parametrize(
    ("length", "change", "message"),
    [
        (1e160, ("drives", "free"), "the inertia of crank at t = 0 is not a finite number"),
        (1e308, ("O: [0, 0]", "O: [1e308, 0]"), "the place of joint A is not a finite number"),
    ],
)
def test_what_overflows_at_the_start_is_an_error_of_the_definition(length, change, message):
    text = CRANK.format(length=length, mass=1, speed=0).replace(*change)
    with pytest.raises(InputError, match=message):
        linkages.simulate(linkages.loads(text))


def test_links_whose_squares_overflow():
    text = (
        "joints: {O: [0, 0], D: [1e300, 0]}\nbars:\n"
        "  a: {joints: [O, A], length: 1e300}\n  b: {joints: [A, B], length: 1e300}\n"
        "  c: {joints: [D, B], length: 1e300}\ndrives: {a: {angle: 1, speed: 0}}\n"
        "assembly: {B: [1, 1]}\n"
    )
    with pytest.raises(InputError, match="b and c are too long for double precision"):
        linkages.simulate(linkages.loads(text))


def test_advantages_may_be_infinite():
    """At its dead centre the crank does not move the slider: a force without bound."""
    data = linkages.simulate(
        linkages.load("slider-crank"), outputs=["slider_mechanical_advantage"], samples=3
    ).data
    assert np.isinf(data.slider_mechanical_advantage[0]).all()


def test_a_motion_ends_before_a_sample():
    solution = linkages.simulate(linkages.load("pendulum"), end=0.1, samples=11)
    part = solution.motion.part(last=4)
    assert part.time.tolist() == solution.motion.time[:4].tolist()
    assert part.state.tolist() == solution.motion.state[:, :4].tolist()
    assert solution.motion.part(last=0).time.size == 0
