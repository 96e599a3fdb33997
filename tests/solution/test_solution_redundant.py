"""More constraints than coordinates: they repeat each other, the motion is that without them."""

import numpy as np
import pytest
from solution_mechanisms import mechanism

import linkages
from linkages import InputError

COUPLERS = """\
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.3, 0]}
bars:
  crank: {points: {O: [0, 0], A: [0.1, 0], P: [0.05, 0.04]}, mass: 0.5, center: [0.04, 0.01],
          inertia: 1e-3}
  rocker: {points: {D: [0, 0], B: [0.1, 0], Q: [0.05, 0.04]}, mass: 0.4, center: [0.05, 0],
           inertia: 8e-4}
  coupler: {joints: [A, B], length: 0.3, mass: 0.6}
"""
SECOND = "  second: {joints: [P, Q], length: 0.3, mass: 0.7}\n"
# A coupler of a parallelogram moves like its ends: a point mass on the crank does the same.
CARRIED = "masses: {P: 0.7}\n"
LEFT = "assembly: {B: [0.39, 0.05]}"
DRIVEN, FREE = "drives: {crank: {angle: 0.5, speed: 5}}", "free: {crank: {angle: 0.5, speed: 20}}"
CRANKS = """\
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.3, 0], E: [0.1, 0.2]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 0.5}
  other: {joints: [D, B], length: 0.1, mass: 0.5}
  plate: {points: {A: [0, 0], B: [0.3, 0], C: [0.1, 0.2]}, mass: 1, center: [0.1, 0.05],
          inertia: 1e-2}
"""
THIRD = "  third: {joints: [E, C], length: 0.1, mass: 0.4}\n"
PLACES = "assembly: {B: [0.39, 0.05], C: [0.19, 0.25]}"


def both(text, extra, instead, *sections, places, **arguments):
    """With the redundant bar, and with something that moves as it does."""
    return [
        linkages.simulate(
            mechanism(changed, *sections, places), outputs="all", change_points="pass", **arguments
        )
        for changed in (text + extra, text + instead)
    ]


@pytest.mark.slow
def test_a_mechanism_that_moves_is_no_structure():
    """Grübler's formula gives 0 for two couplers, but the closure's rank says that they move."""
    with pytest.raises(InputError, match="mobility is 1, but 0 coordinates are driven and 0 free"):
        linkages.simulate(mechanism(COUPLERS + SECOND, LEFT))


def test_two_couplers_driven():
    found, wanted = both(COUPLERS, SECOND, CARRIED, DRIVEN, places=LEFT, end=1.0, samples=201)
    assert found.system.topology.redundant
    assert wanted.system.topology.redundant == ()
    data, other = found.data, wanted.data
    assert float(data.closure_residual.max()) <= 1e-13
    for name in ("drive_effort", "kinetic_energy", "energy_residual", "drive_power"):
        scale = max(1.0, float(np.abs(other[name]).max()))
        # where bars are in line the one without a second coupler has change points: ε/m³
        assert data[name].to_numpy() == pytest.approx(other[name].to_numpy(), abs=1e-7 * scale)
    angle = 0.5 + 5 * data.time.to_numpy()
    for bar in ("crank", "rocker"):
        assert data.bar_angle.sel(bar=bar).to_numpy() == pytest.approx(angle, abs=1e-13)
    for bar in ("coupler", "second"):
        assert data.bar_angle.sel(bar=bar).to_numpy() == pytest.approx(0, abs=1e-13)


def test_two_couplers_free():
    found, wanted = both(
        COUPLERS, SECOND, CARRIED, FREE, places=LEFT, end=1.0, samples=201, rtol=1e-11
    )
    data = found.data
    for bar in ("crank", "rocker"):
        assert data.bar_angle.sel(bar=bar).to_numpy() == pytest.approx(
            wanted.data.bar_angle.sel(bar=bar).to_numpy(), abs=1e-8
        )
    assert float(data.closure_residual.max()) <= 1e-13
    assert float(np.abs(data.energy_residual).max()) < 1e-9
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy == pytest.approx(energy[0], abs=1e-9)


def test_three_cranks():
    """The plate moves without turning: the third crank's centre goes round like that of the others.

    A massless third crank changes nothing; with its mass the effort is larger by that of a single
    crank of its own.
    """
    found, wanted = both(
        CRANKS, THIRD, "", DRIVEN, places=PLACES.replace(", C: [0.19, 0.25]", ""), end=1.0,
        samples=201,
    )  # fmt: skip
    data = found.data
    angle = 0.5 + 5 * data.time.to_numpy()
    alone = 0.4 * 9.81 * 0.05 * np.cos(angle)
    effort = wanted.data.drive_effort.to_numpy()[:, 0] + alone
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(effort, abs=1e-7)
    assert data.bar_angle.sel(bar="third").to_numpy() == pytest.approx(angle, abs=1e-13)
    assert data.bar_angle.sel(bar="plate").to_numpy() == pytest.approx(0, abs=1e-13)
    assert float(data.closure_residual.max()) <= 1e-13
    # power near change points is right to ε/m³
    assert float(np.abs(data.energy_residual).max()) < 1e-9


@pytest.mark.slow_except("2.0")
@pytest.mark.parametrize("end", [2.0, -2.0])
def test_three_cranks_free(end):
    solution = linkages.simulate(
        mechanism(CRANKS + THIRD, FREE, PLACES), end=end, samples=401, rtol=1e-11, outputs="all"
    )
    data = solution.data
    assert float(np.abs(data.energy_residual).max()) < 1e-9
    assert float(data.closure_residual.max()) <= 1e-13
    turned = data.bar_angle.sel(bar="third") - data.bar_angle.sel(bar="crank")
    assert turned.to_numpy() == pytest.approx(0, abs=1e-12)
    assert abs(float(data.bar_angle.sel(bar="crank")[-1])) > 30


def test_reactions_are_said_to_be_one_choice():
    """Their sum is determined all the same: the ground carries what accelerates."""
    solution = linkages.simulate(
        mechanism(COUPLERS + SECOND, DRIVEN, LEFT), end=0.5, samples=51, outputs="all"
    )
    (note,) = [n for n in solution.notes if "redundant" in n]
    assert "least sum of squares" in note
    assert any(joint in note for joint in solution.system.topology.redundant)
    data = solution.data
    ground = sum(data.joint_reaction.sel(joint=j).to_numpy() for j in ("O", "D"))
    masses = {"crank": 0.5, "rocker": 0.4, "coupler": 0.6, "second": 0.7}
    # centres: crank and rocker as given, couplers in the middle of their level ends
    angle = 0.5 + 5 * data.time.to_numpy()
    turn = np.exp(1j * angle)
    acceleration = -25 * turn * (
        0.5 * (0.04 + 0.01j) + 0.4 * 0.05 + 0.6 * 0.1 + 0.7 * (0.05 + 0.04j)
    )  # fmt: skip
    expected = acceleration + 9.81j * sum(masses.values())
    assert ground[:, 0] == pytest.approx(expected.real, abs=1e-9)
    assert ground[:, 1] == pytest.approx(expected.imag, abs=1e-9)


def test_no_note_without_redundancy_or_without_reactions():
    plain = linkages.simulate(mechanism(COUPLERS, DRIVEN, LEFT), end=0.1, samples=3, outputs="all")
    assert not [n for n in plain.notes if "redundant" in n]
    found = mechanism(COUPLERS + SECOND, DRIVEN, LEFT)
    assert not [n for n in linkages.simulate(found, end=0.1, samples=3).notes if "redundant" in n]


@pytest.mark.parametrize("length", [0.31, 0.3001, 0.3 + 1e-6, 0.3 + 1e-7])
def test_contradiction_is_refused(length):
    """A second coupler of another length: nothing could move."""
    text = COUPLERS + SECOND.replace("0.3,", f"{length!r},")
    with pytest.raises(InputError, match=r"redundant|constraints|mobility|assembled"):
        linkages.simulate(mechanism(text, DRIVEN, LEFT), end=0.1)


def test_a_length_within_round_off_of_a_file_is_taken():
    """Nine digits, as programs print them, are enough."""
    text = COUPLERS + SECOND.replace("0.3,", "0.3000000003,")
    assert linkages.simulate(mechanism(text, DRIVEN, LEFT), end=0.1, samples=3).completed


def turned_pin(off):
    """The second coupler's pin Q moved across it: its length is right to off²/2, not its motion."""
    x, y = 0.05 + off * np.sin(0.5), 0.04 + off * np.cos(0.5)
    return (COUPLERS + SECOND).replace("Q: [0.05, 0.04]", f"Q: [{float(x)!r}, {float(y)!r}]")


@pytest.mark.parametrize("off", [1e-3, 1e-5, 1e-6])
def test_constraints_that_contradict_each_other_in_velocity_alone_are_refused(off):
    """They miss by off/0.1 of the speed of a pin, where 1e-7 is allowed, and by off² in place."""
    assert off**2 / 2 < 1e-6
    with pytest.raises(InputError, match=r"would not let crank move|contradict"):
        linkages.simulate(mechanism(turned_pin(off), DRIVEN, LEFT), end=0.1)


def test_velocities_within_round_off_of_a_file_are_taken():
    found = mechanism(turned_pin(1e-11), DRIVEN, LEFT)
    assert linkages.simulate(found, end=0.1, samples=3).completed


FRAME = """\
joints: {O: [0, 0], C: [1, 0]}
bars:
  frame: {points: {O: [0, 0], C: [LENGTH, 0], P: [0.5, 0.5]}}
  crank: {joints: [P, Q], length: 0.2}
welds: {O: {bars: [ground, frame], angle: 0}}
drives: {crank: {angle: 0, speed: 1}}
"""


def test_loops_that_determine_nothing_are_part_of_the_residual():
    """A frame welded to the ground and pinned to it, 5 nm too long."""
    text = FRAME.replace("LENGTH", "1.000000005")
    data = linkages.simulate(mechanism(text), end=0.1, samples=3).data
    assert data.closure_residual.to_numpy() == pytest.approx(5e-9, abs=1e-14)
    with pytest.raises(InputError, match="contradict each other"):
        linkages.simulate(mechanism(FRAME.replace("LENGTH", "1.0000001")), end=0.1)


YOKES = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 50 mm, mass: 0.3}}
sliders:
  yoke: {joint: Y, through: O, angle: 0, mass: 1.5}
  pin: {joint: A, 'on': yoke, through: Y, angle: 90 deg, mass: 0.05}
  other: {joint: Y, through: O, angle: 0, mass: 1.5}
drives: {crank: {angle: 0, speed: 120 rpm}}
assembly: {A: [50 mm, 0]}
simulate: {end: 1}
"""


def test_a_constraint_that_is_a_system_of_constants():
    """Two sliders at one joint on one axis: x = 50 mm cos ωt for both."""
    data = linkages.simulate(linkages.loads(YOKES), times=np.linspace(0, 1, 101)).data
    exact = 0.05 * np.cos(4 * np.pi * data.time.to_numpy())
    for name in ("yoke", "other"):
        assert np.abs(data.slider_position.sel(slider=name) - exact).max() < 1e-9
