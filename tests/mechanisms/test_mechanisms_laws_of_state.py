"""Loads whose laws nobody has thought of, as data: a function of x, v and t along any measure.

Against closed forms, Lagrange's equations derived with SymPy, and the absolute formulation, which
also gives the joint reactions.
"""

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from definition_terms import mechanism_of
from kernel_values import assert_motion_agrees
from lagrange_equations import assert_satisfies_lagrange
from scipy.special import ellipj

import linkages
from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.evidence import conservative
from linkages.cli.verbs.contribution_rows import loads
from linkages.kernel.system import System
from linkages.plots.mechanism import drawing

ROD = {"joints": {"O": (0.0, 0.0)}, "bars": {"rod": {"joints": ("O", "P"), "length": 0.6}}}
MASS, INERTIA = 1.2, 0.05
RUN = {"rtol": 1e-12, "atol": 1e-14}
CLOSE = 1e-10
"""Of integration at a tolerance of 1e-12 over some hundred steps."""


def turning(law, speed=0.0, angle=0.3):
    """A rod without mass but for its inertia about O, with a law of its angle."""
    rod = {**ROD["bars"]["rod"], "mass": 0.0, "inertia": INERTIA}
    free = {"rod": {"angle": angle, "speed": speed}}
    acting = [{"bar": "rod", "law": law}]
    return mechanism_of({**ROD, "bars": {"rod": rod}, "free": free, "loads": acting})


def sliding(*entries, position=0.0, speed=0.0, angle=0.4):
    """A block on an inclined axis through O."""
    block = {"joint": "B", "mass": MASS, "angle": angle}
    free = {"block": {"position": position, "speed": speed}}
    joints = {"joints": {"O": (0.0, 0.0), "C": (0.2, 1.1)}, "bars": {}}
    return mechanism_of({**joints, "sliders": {"block": block}, "free": free, "loads": entries})


def test_dry_friction_slows_a_rod_down():
    """J ω̇ = −M tanh(ω/ω₀): sinh(ω/ω₀) falls as exp(−M t/(J ω₀))."""
    mechanism = turning("-0.07*tanh(v/0.5)", speed=3.0)
    data = linkages.simulate(mechanism, end=3.0, samples=61, outputs="all", **RUN).data
    falling = np.sinh(3.0 / 0.5) * np.exp(-0.07 * data.time / (INERTIA * 0.5))
    assert np.abs(data.bar_speed[:, 0] - 0.5 * np.arcsinh(falling)).max() < 3.0 * CLOSE
    torque = -0.07 * np.tanh(data.bar_speed[:, 0] / 0.5)
    assert np.abs(data.torsional_spring_torque[:, 0] - torque).max() < 1e-15
    assert np.abs(data.load_power - torque * data.bar_speed[:, 0]).max() < 1e-15
    assert float(np.abs(data.energy_residual).max()) < CLOSE * 0.5 * INERTIA * 9.0
    assert not conservative(mechanism)


@pytest.mark.slow
def test_dry_friction_shrinks_volumes_at_its_slope():
    """About rest the sum of both exponents is −M/(J ω₀); getting there takes 1 of the 250 s."""
    mechanism = turning("-0.07*tanh(v/0.5) - 0.4*x*(1 + 0.2*cos(t))", speed=0.2)
    data = linkages.lyapunov(mechanism, periods=40)
    assert float(data.exponent.sum()) == pytest.approx(-0.07 / (INERTIA * 0.5), rel=0.01)


@pytest.mark.parametrize("measure", [{"between": ["O", "B"]}, {"slider": "block"}])
def test_a_cubic_spring_swings_as_an_elliptic_function(measure):
    """m s̈ = −k s³: s = A cn(A √(k/m) t | ½), through the place where the ends of the spring meet.

    Along the distance of its ends this is the same as along the axis, for a multiple of x needs no
    direction.
    """
    mechanism = sliding({**measure, "law": "-50*x**3"}, position=0.4)
    data = linkages.simulate(mechanism, end=4.0, samples=201, outputs="all", **RUN).data
    _, cosine, _, _ = ellipj(0.4 * np.sqrt(50 / MASS) * data.time.to_numpy(), 0.5)
    assert np.abs(data.slider_position[:, 0] - 0.4 * cosine).max() < 0.4 * CLOSE
    assert data.slider_position.min() < -0.39  # it did pass
    stored = 50 * data.slider_position[:, 0] ** 4 / 4
    assert np.abs(data.potential_energy - stored).max() < 1e-15
    assert not data.load_power.any()
    assert float(np.abs(data.energy_residual).max()) < CLOSE * 50 * 0.4**4 / 4
    assert conservative(mechanism)


def test_friction_between_ends_that_meet_acts_against_their_motion():
    """−F tanh(v/v₀) along a distance that passes zero: the ends' velocity has a direction there."""
    mechanism = sliding({"between": ["O", "B"], "law": "-3*tanh(v/0.2)"}, position=-0.2, speed=1.0)
    data = linkages.simulate(mechanism, end=0.6, samples=61, outputs="all", **RUN).data
    falling = np.sinh(1.0 / 0.2) * np.exp(-3 * data.time / (MASS * 0.2))
    assert np.abs(data.slider_velocity[:, 0] - 0.2 * np.arcsinh(falling)).max() < CLOSE
    assert data.slider_position.max() > 0.01
    met = System(sliding({"between": ["O", "B"], "law": "-3*tanh(v/0.2)"}, speed=0.1))
    (found,) = met.evaluate(met.model.free_accelerations)[:, 0]
    assert found == pytest.approx(-3 * np.tanh(0.5) / MASS, rel=1e-14)
    swift = System(sliding({"between": ["O", "B"], "law": "-3*v**3"}, speed=0.5))
    (found,) = swift.evaluate(swift.model.free_accelerations)[:, 0]
    assert found == pytest.approx(-3 * 0.5**3 / MASS, rel=1e-14)
    rests = System(sliding({"between": ["O", "B"], "law": "-3*tanh(v/0.2)"}))
    assert rests.evaluate(rests.model.free_accelerations)[0, 0] == 0.0


def test_a_force_along_a_distance_has_no_direction_where_its_ends_meet():
    with pytest.raises(linkages.InputError, match=r"loads\[0\]: .*its ends O and B meet"):
        System(sliding({"between": ["O", "B"], "law": "-3 - 2*x"}))


def test_pin_and_drive_hold_what_a_law_pulls():
    """A driven rod without mass: reaction and effort are those of the loads alone."""
    rod = {**ROD["bars"]["rod"], "mass": 0.0, "inertia": 0.0}
    drives = {"rod": {"angle": 0.2, "speed": 2.0}}
    acting = [
        {"between": ["C", "P"], "law": "-5*x**3"},
        {"joint": "P", "axis": 1, "law": "-4*x**2 - v"},
        {"bar": "rod", "law": "-0.3*tanh(v)"},
    ]
    joints = {"O": (0.0, 0.0), "C": (0.2, 1.1)}
    mechanism = mechanism_of(
        {"joints": joints, "bars": {"rod": rod}, "drives": drives, "loads": acting}
    )
    data = linkages.simulate(mechanism, end=3.0, samples=31, outputs="all").data
    angle = 0.2 + 2.0 * data.time.to_numpy()
    place, velocity = 0.6 * np.exp(1j * angle), 1.2j * np.exp(1j * angle)
    way = place - (0.2 + 1.1j)
    force = -5 * np.abs(way) ** 2 * way + 1j * (-4 * place.imag**2 - velocity.imag)
    found = data.joint_reaction.sel(joint="O").to_numpy() @ [1, 1j]
    largest = np.abs(force).max()
    assert np.abs(found + force).max() < 1e-14 * largest
    effort = 0.3 * np.tanh(2.0) - (np.conj(place) * force).imag
    assert np.abs(data.drive_effort[:, 0] - effort).max() < 1e-14 * largest


LINKAGE = {
    "gravity": (1.0, -9.81),
    "joints": {"O": (0.0, 0.0), "C": (1.0, 0.2)},
    "bars": {
        "crank": {"joints": ("O", "A"), "length": 0.3, "mass": 1.0},
        "rod": {"joints": ("A", "B"), "length": 0.9, "mass": 1.0},
        "rocker": {"joints": ("C", "B"), "length": 0.7, "mass": 1.0},
        "tail": {"joints": ("B", "T"), "length": 0.4, "mass": 0.6},
    },
    "sliders": {"bead": {"joint": "W", "on": "rocker", "angle": 0.2, "mass": 0.5}},
    "free": {
        "crank": {"angle": 0.8, "speed": 1.5},
        "tail": {"angle": 0.3, "speed": -2.0},
        "bead": {"position": 0.2, "speed": 0.7},
    },
    "assembly": {"B": "left"},
}
# Loads act on bodies without a coordinate of their own as well: efforts of free coordinates, which
# must come out as zero, would take up whatever is wrong with loads on others.
LAWS = {
    "dry friction": {"bars": ["rod", "rocker"], "law": "-0.7*tanh(v/0.4)"},
    "cubic spring": {"between": ["W", "T"], "law": "-30*x**3"},
    "gas strut": {"between": ["C", "T"], "law": "12 - 40*(x - 0.5) - 0.3*v*x"},
    "stiffening": {"bar": "tail", "law": "3*(0.4 - x)*(x**2 + 1)"},
    "drag": {"slider": "bead", "law": "-2*v*sqrt(v**2 + 0.01)"},
    "wall": {"joint": "T", "axis": 1, "law": "5*exp(-3*x) - 0.2*v"},
    "parametric": {"bars": ["rocker", "tail"], "law": "-(2 + sin(3*t))*(x - 0.3)"},
    "cylinder": {"between": ["A", "T"], "law": "7.5*cos(7*t)"},
    "one-sided": {"slider": "bead", "law": "select(0.1 - x, 400*(0.1 - x), 0)"},
}


def linkage(*names):
    return mechanism_of({**LINKAGE, "loads": [LAWS[name] for name in names]})


@pytest.mark.slow_except("cylinder")
@pytest.mark.parametrize("name", LAWS)
def test_lagrange_equations_agree(name):
    assert_satisfies_lagrange(linkage(name), count=20, least=10)


def test_absolute_formulation_agrees():
    """Motion, efforts, joint reactions and the energy balance with all of them together."""
    mechanism = linkage(*LAWS)
    data = linkages.simulate(mechanism, end=0.3, samples=4, outputs="all", rtol=1e-11).data
    assert_motion_agrees(AbsoluteModel(mechanism), data, 1e-11, 1e-9)  # as for random mechanisms


@pytest.mark.parametrize(
    ("name", "dissipates", "turned", "potential"),
    [
        ("dry friction", True, (), False),
        ("cubic spring", False, (), True),
        ("gas strut", True, (), True),
        ("stiffening", False, ("tail",), True),
        ("drag", True, (), False),
        ("wall", True, (), False),
        ("parametric", False, ("tail", "rocker"), False),
        ("cylinder", False, (), False),
        ("one-sided", False, (), False),
    ],
)
def test_what_follows_from_the_form_of_a_law(name, dissipates, turned, potential):
    mechanism = linkage(name)
    (load,) = mechanism.loads
    assert conservative(mechanism) == (not dissipates)
    assert load.turned == turned
    system = System(mechanism)
    bare = System(linkage())
    stored, gravity = (s.evaluate([s.model.potential_energy])[0, 0] for s in (system, bare))
    assert (stored != gravity) == potential


def test_a_period_comes_from_the_factors_that_depend_on_time():
    with pytest.raises(NoPeriodError, match="nothing depends on time"):
        common_period(linkage("cubic spring"))
    assert common_period(linkage("parametric")) == pytest.approx(2 * np.pi / 3, rel=1e-12)


@pytest.mark.slow
def test_reports_and_drawings_leave_none_out():
    mechanism = linkage(*LAWS)
    assert [(row["kind"], row["on"], row["value"]) for row in loads(mechanism)] == [
        ("torsional damper", "rocker against rod", "a law of v"),
        ("spring", "joints W and T", "a law of x"),
        ("spring", "joints C and T", "12 N, 40 N/m, length 0.5 m, a law of x and v"),
        ("torsional spring", "tail", "a law of x"),
        ("damper", "bead in its guide", "a law of v"),
        ("spring", "y of joint T", "damping 0.2 N s/m, a law of x"),
        ("torsional spring", "tail against rocker", "a law of x and t"),
        ("force", "joints A and T", "-7.5 to 7.5 N until t = 1 s"),
        ("spring", "bead in its guide", "a law of x"),
    ]
    data = linkages.simulate(mechanism, end=0.1, samples=3).data
    bare = _patches(data, linkage())
    for name in LAWS:
        drawn = _patches(data, linkage(name)) - bare
        assert drawn >= (2 if name == "gas strut" else 1), name  # a spring and a damper


def _patches(data, mechanism):
    return len(drawing.figure(data, mechanism).axes[0].patches)
