"""Whole turns of dependent bars: counted, whatever the samples are."""

import numpy as np
import pytest
from solution_mechanisms import mechanism

import linkages

GROUND, CRANK, COUPLER, FOLLOWER = 0.1, 0.3, 0.25, 0.3
DRAG_LINK = f"""\
joints: {{A: [0, 0], D: [{GROUND}, 0]}}
bars:
  crank: {{joints: [A, B], length: {CRANK}, mass: 1}}
  coupler: {{joints: [B, C], length: {COUPLER}, mass: 0.4}}
  follower: {{joints: [D, C], length: {FOLLOWER}, mass: 0.7}}
assembly: {{C: left}}
"""
START = 0.3
CLOSE = 1e-12
"""Of closed forms; a bar that is off by a turn is off by 6.3."""


def drag_link(crank):
    """Angles of coupler and follower, continuous in the crank's.

    F. Freudenstein's equation solved for the drag link: the crank pin B goes round D, so that the
    direction from D to B is θ + arg(1 − (d/a) e^{−iθ}), whose second part never leaves ±90°; the
    triangle B, C, D adds an angle between 0 and 180°.
    """
    pin = CRANK * np.exp(1j * crank) - GROUND
    direction = crank + np.angle(1 - GROUND / CRANK * np.exp(-1j * crank))
    gap = np.abs(pin)
    at_pin = np.arccos((gap**2 + COUPLER**2 - FOLLOWER**2) / (2 * gap * COUPLER))
    at_pivot = np.arccos((gap**2 + FOLLOWER**2 - COUPLER**2) / (2 * gap * FOLLOWER))
    return direction + np.pi + at_pin, direction - at_pivot


def check_drag_link(data, tolerance=CLOSE):
    """Both angles up to the whole turns of t = 0, at which they lie in [-π, π]."""
    crank = data.bar_angle.sel(bar="crank").to_numpy()
    for bar, angle in zip(("coupler", "follower"), drag_link(crank), strict=True):
        found = data.bar_angle.sel(bar=bar).to_numpy()
        assert abs(found[0]) <= np.pi
        assert found[0] == pytest.approx((angle[0] + np.pi) % (2 * np.pi) - np.pi, abs=tolerance)
        assert found - found[0] == pytest.approx(angle - angle[0], abs=tolerance)


def ends_alike(found, **arguments):
    """Runs with few and many samples have the same angles at common times."""
    many = linkages.simulate(found, samples=1001, outputs=["bar_angle"], **arguments).data
    for samples in (2, 3, 6, 11, 101):
        few = linkages.simulate(found, samples=samples, outputs=["bar_angle"], **arguments).data
        wanted = many.bar_angle.to_numpy()[:: 1000 // (samples - 1)]
        # dense output of one step: to its order
        assert few.bar_angle.to_numpy() == pytest.approx(wanted, abs=1e-5), samples
    return many


@pytest.mark.parametrize("samples", [2, 11, 1001])
@pytest.mark.parametrize("end", [20.0, -20.0])
def test_a_drag_link_at_3000_rpm_makes_1000_turns(samples, end):
    found = mechanism(DRAG_LINK, f"drives: {{crank: {{angle: {START}, speed: 3000 rpm}}}}")
    data = linkages.simulate(found, end=end, samples=samples).data
    check_drag_link(data, 1e-9)  # the crank's angle of 6283 rad is right to 1e-12
    turned = (data.bar_angle[-1] - data.bar_angle[0]).to_numpy() / (2 * np.pi)
    assert turned == pytest.approx(1000 * np.sign(end), abs=1e-9)


METHODS = [
    {"method": "dop853", "rtol": 1e-9}, {"method": "dop853", "rtol": 1e-2},
    {"method": "vern9", "rtol": 1e-6}, {"method": "tsit5", "rtol": 1e-4},
    {"method": "rk4", "step": 0.02}, {"method": "gauss8", "step": 0.05},
    {"method": "radau", "rtol": 1e-5},
]  # fmt: skip


@pytest.mark.slow_except("2-[!r]*", "2-rk4*")
@pytest.mark.parametrize("how", METHODS, ids=lambda how: "-".join(map(str, how.values())))
@pytest.mark.parametrize("samples", [2, 40])
def test_a_free_drag_link_is_counted_by_every_method(how, samples):
    """Whatever the error of the crank's motion: the others are where the crank puts them."""
    found = mechanism(DRAG_LINK, f"free: {{crank: {{angle: {START}, speed: 12}}}}")
    data = linkages.simulate(found, end=-4.0, samples=samples, **how).data
    assert data.bar_angle.sel(bar="crank")[-1] < -25  # four turns
    check_drag_link(data)


PARALLELOGRAM = """\
joints: {O: [0, 0], D: [0.3, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  coupler: {joints: [A, B], length: 0.3, mass: 1}
  rocker: {joints: [D, B], length: 0.1, mass: 1}
assembly: {B: left}
"""


@pytest.mark.slow_except("drives*-2", "free*-7")
@pytest.mark.parametrize("samples", [2, 7, 101])
@pytest.mark.parametrize(
    "section", ["drives: {crank: {angle: 1, speed: 40}}", "free: {crank: {angle: 1, speed: 40}}"]
)
def test_turns_are_counted_through_change_points(section, samples):
    """A parallelogram stays one: its rocker turns with its crank, its coupler not at all."""
    data = linkages.simulate(
        mechanism(PARALLELOGRAM, section), end=5.0, samples=samples, change_points="pass"
    ).data
    crank, coupler, rocker = data.bar_angle.to_numpy().T
    assert crank[-1] > 190
    assert rocker == pytest.approx(crank, abs=1e-7)
    assert coupler == pytest.approx(0, abs=1e-7)


SWINGING = """\
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.3, 0]}
bars:
  crank: {joints: [O, A], length: 0.25, mass: 1}
  coupler: {joints: [A, B], length: 0.12, mass: 0.5}
  rocker: {joints: [D, B], length: 0.22, mass: 0.8}
free: {crank: {angle: 1.2, speed: 30}}
assembly: {B: [0.2, 0.3]}
"""


def test_turns_are_counted_over_exchanges_of_coordinates():
    """No bar can be the free one for long; the coupler, the shortest, turns."""
    data = ends_alike(mechanism(SWINGING), end=2.0, rtol=1e-9)
    solution = linkages.simulate(mechanism(SWINGING), end=2.0, samples=3)
    assert any("was exchanged for" in note for note in solution.notes)
    assert np.ptp(data.bar_angle.sel(bar="coupler").to_numpy()) > 10
    steps = np.abs(np.diff(data.bar_angle.to_numpy(), axis=0))
    assert steps.max() < 1.0


@pytest.mark.slow_except("jansen", "five-bar-free")
@pytest.mark.parametrize(
    "name",
    ["jansen", "five-bar-free", "andrews", "class-three", "klann", "n-four-bar", "ninebar",
     "ninebar-rotating", "peaucellier", "quick-return", "toggle-press", "stephenson-six-bar",
     "watt-six-bar"],
)  # fmt: skip
def test_the_library_does_not_depend_on_samples(name):
    ends_alike(linkages.load(name))


FAST = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.1, mass: 1}}
drives: {crank: {angle: 0, speed: 1e30}}
simulate: {end: 5 ms}
"""


def test_drives_too_fast_to_be_followed():
    """Where nothing has to be counted nothing is looked at; work would need 1e28 places."""
    mechanism = linkages.loads(FAST)
    assert linkages.simulate(mechanism).data.bar_speed[-1, 0] == 1e30
    with pytest.raises(ValueError, match="expected a slower drive, a shorter time, or max_steps"):
        linkages.simulate(mechanism, outputs="energy_residual")
