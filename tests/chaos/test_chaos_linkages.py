"""Sections, exponents, diagrams and verdicts of linkages."""

import json

import numpy as np
import pytest
from chaos_systems import exponents_of

import linkages
from linkages.chaos.contact_log import contact_check
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.exponents import lyapunov_spectrum
from linkages.chaos.findings import verdict
from linkages.chaos.lyapunov import pair_sums
from linkages.chaos.maps import chaos_map
from linkages.errors import ComputationError, InputError
from linkages.kernel.code.program import bind_kernel
from linkages.kernel.state_jumps import write_jacobian
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.guards import parse_section
from linkages.solvers.flow import caller
from linkages.solvers.integration import FIXED_STEP_METHODS, METHODS
from linkages.sweeps.axes import parse_range, together
from linkages.sweeps.running import Threads

# The starts of the reproduction: θ1 = 15°, θ4 = 150°, at rest in the clearance.
START = {"drives.crank1.angle": "15 deg", "drives.crank4.angle": "150 deg"}

DAMPED_PENDULUM = """\
name: Driven damped double pendulum
joints: {O: [0, 0]}
bars: {upper: {joints: [O, A], length: 1, mass: 1}, lower: {joints: [A, B], length: 1, mass: 1}}
gravity: [0, -9.81]
free: {upper: {angle: -80 deg}, lower: {angle: -85 deg}}
dampers: [{joint: O, damping: 0.1}, {joint: A, damping: 0.1}]
loads: [{bar: upper, torque: "AMPLITUDE*cos(2*pi*t)"}]
simulate: {end: 1, rtol: 1e-9}
"""

TWO_CLEARANCES = {
    "clearances": {
        "a": {"joint": "A", "bar": "rod", "size": "0.2 mm"},
        "b": {"joint": "B", "bar": "rod", "size": "0.1 mm", "angle": 1},
    }
}


def ninebar(**changes: object) -> linkages.Mechanism:
    return linkages.load("ninebar", set={**START, **changes})


def pendulum(amplitude: float) -> linkages.Mechanism:
    text = DAMPED_PENDULUM.replace("AMPLITUDE", repr(amplitude))
    return linkages.loads(text)


def test_stroboscopic_section_is_the_motion_at_whole_periods():
    data = linkages.poincare(ninebar(), periods=4, skip=1, phase=0.25)
    assert data.time.to_numpy() == pytest.approx([2.5, 4.5, 6.5, 8.5], abs=1e-12)
    assert data.clearance_angle.dims == ("crossing", "clearance")
    assert data.clearance_speed.attrs["units"] == "rad/s"
    outputs = ["clearance_angle", "clearance_speed"]
    whole = linkages.simulate(ninebar(), end=8.5, samples=18, outputs=outputs).data
    angle = whole.clearance_angle.sel(time=[2.5, 4.5, 6.5, 8.5], method="nearest")
    turned = np.remainder(angle.to_numpy() - data.clearance_angle.to_numpy() + 3, 2 * np.pi) - 3
    assert np.abs(turned).max() < 1e-8  # two runs at rtol 1e-10 with other sample times


@pytest.mark.slow_except("down*")
@pytest.mark.parametrize(("direction", "sign"), [("up", 1), ("down", -1)])
def test_geometric_section_is_located_exactly(direction, sign):
    section = "slider9.velocity=0"
    data = linkages.poincare(ninebar(), periods=6, section=section, direction=direction)
    # each crossing again, by a run that ends there
    for time, angle in zip(data.time.to_numpy(), data.clearance_angle.to_numpy(), strict=True):
        outputs = ["slider_velocity", "slider_acceleration", "clearance_angle"]
        end = linkages.simulate(ninebar(), end=float(time), samples=2, outputs=outputs).data
        # two runs at rtol 1e-10 whose steps differ
        assert abs(float(end.slider_velocity[-1, 0])) < 1e-8
        assert np.sign(float(end.slider_acceleration[-1, 0])) == sign
        assert np.cos(float(end.clearance_angle[-1, 0]) - angle) == pytest.approx(1, abs=1e-12)


def test_section_at_an_angle_takes_whole_turns_only():
    mechanism = linkages.load("double-pendulum")
    name = next(iter(mechanism.bodies))
    found = linkages.poincare(mechanism, periods=5, section=f"{name}.angle=-90 deg")
    assert np.abs(found.bar_angle.sel(bar=name) + np.pi / 2).max() < 1e-9
    assert (found.bar_speed.sel(bar=name) > 0).all()


SWINGING = """\
name: Pendulum
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
free: {arm: {angle: ANGLE}}
simulate: {end: 20, rtol: 1e-10}
"""


def arm(angle: str) -> linkages.Mechanism:
    return linkages.loads(SWINGING.replace("ANGLE", angle))


def test_crossings_half_a_turn_away_take_no_place():
    """The upper bar swings through the bottom for 12 s before it first goes over the top."""
    section = {"section": "upper.angle=90 deg", "direction": "both", "end": 60, "rtol": 1e-11}
    # later ones are beyond the horizon: another tolerance has them elsewhere
    whole = linkages.poincare(pendulum(20.0), periods=4, **section)
    assert whole.sizes["crossing"] == 4
    assert np.abs(whole.bar_angle.sel(bar="upper") - np.pi / 2).max() < 1e-9
    for count in (1, 2):
        found = linkages.poincare(pendulum(20.0), periods=count, **section)
        assert found.time.to_numpy() == pytest.approx(whole.time[:count].to_numpy(), abs=1e-9)


def test_default_end_leaves_room_for_the_last_crossing():
    """The damped arm follows its torque, and comes to rest once a period."""
    text = DAMPED_PENDULUM.replace("AMPLITUDE", "0.5").replace("damping: 0.1", "damping: 5")
    mechanism = linkages.loads(text)
    for skip in (5, 6):
        found = linkages.poincare(mechanism, periods=4, skip=skip, section="upper.speed=0")
        assert (found.sizes["crossing"], found.attrs["warning"]) == (4, "")


def test_only_crossings_of_the_angle_itself_are_counted():
    with pytest.raises(ComputationError, match="is crossed 0 times within 20 s; expected"):
        linkages.poincare(arm("-60 deg"), periods=2, section="arm.angle=90 deg", end=20)


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("slidr9.velocity=0", "did you mean 'slider9.velocity'"),
        ("slider9.speed=0", "expected position or velocity"),
        ("slider9.velocity", "expected a section such as 'r1.speed=0'"),
        ("slider9.velocity=3 kg", "kg"),
    ],
)
def test_bad_sections(section, words):
    with pytest.raises(ValueError, match=words):
        parse_section(System(ninebar()), section)


def test_requests_that_make_no_sense():
    with pytest.raises(InputError, match="nothing is free to move"):
        linkages.poincare(linkages.load("ninebar-ideal"))
    with pytest.raises(ValueError, match=r"geometric section instead, such as 'upper\.speed=0'"):
        linkages.poincare(linkages.load("double-pendulum"))
    with pytest.raises(ComputationError, match="is crossed 0 times"):
        linkages.poincare(ninebar(), periods=2, section="slider9.position=9")
    with pytest.raises(ValueError, match="at least two values"):
        linkages.bifurcation(ninebar(), {"clearances.r1.size": [1e-4]})
    with pytest.raises(InputError, match="did you mean 'size'"):
        linkages.bifurcation(ninebar(), {"clearances.r1.sise": [1e-4, 2e-4]})
    with pytest.raises(ValueError, match="at least 200 periods"):
        verdict(ninebar(), periods=10)


@pytest.mark.slow
def test_exponents_come_in_pairs_without_dissipation():
    exponents = exponents_of(ninebar(**{"clearances.r1.angle": "90 deg"}), periods=20)
    sums, errors = pair_sums(exponents)
    # per period tangents grow by e, and nothing is lost but round-off and tolerance
    assert np.abs(sums).max() < max(1e-3, 4 * errors.max())


def test_sum_of_exponents_is_the_mean_divergence():
    """The divergence is Σ ∂a_i/∂v_i, from the exact Jacobian; friction makes it negative."""
    mechanism = pendulum(3.0)
    system = System(mechanism)
    exponents = exponents_of(mechanism, periods=40)
    model = system.model
    jacobian = bind_kernel(write_jacobian(model, model.free_accelerations), system.parameters)

    class Kernel:
        clock, rates = jacobian.clock, jacobian.rates
        parameters, timed_size = jacobian.parameters, jacobian.timed_size

    evaluate = caller(Kernel, 2 * 2 * 2 + 2 * len(model.margins))

    def divergence(time: float, state: np.ndarray) -> float:
        rows = evaluate(time, state)[1][:8].reshape(2, 4)
        return float(rows[0, 2] + rows[1, 3])

    fine = lyapunov_spectrum(LinkageTangents(system, 4), intervals=4000, interval=0.01)
    mean = np.mean([divergence(t, y) for t, y in zip(fine.times, fine.states, strict=True)])
    assert fine.sum[0] == pytest.approx(mean, rel=2e-3)  # a mean over 4000 samples
    assert exponents.sum[0] == pytest.approx(fine.sum[0], rel=2e-2)  # over 40 s both


def test_tangents_are_derivatives_of_the_motion():
    """Against differences of two motions that start beside each other."""
    system = System(ninebar())
    tangents = LinkageTangents(system, 2, RunOptions(rtol=1e-12))
    step = 1e-6
    tangents.advance(0.05)
    for column in range(2):
        ends = []
        for side in (step, -step):
            start = system.at(0.0, system.state + side * np.eye(2)[column])
            beside = LinkageTangents(start, 2, RunOptions(rtol=1e-12))
            beside.advance(0.05)
            ends.append(beside.state)
        expected = (ends[0] - ends[1]) / (2 * step)
        assert tangents.tangents[:, column] == pytest.approx(expected, rel=1e-5, abs=1e-4)


def test_tangents_are_integrated_accurately_where_the_motion_asks_for_no_steps():
    """A pendulum at rest upside down: exponents are ±√(g/l), and steps are those of tangents.

    Each of some steps within 2 s errs by the tolerance of tangents, 1e-6 of their length.
    """
    text = """\
name: Upside down
gravity: [-9.81, 0]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
free: {arm: {angle: 0, speed: 0}}
simulate: {end: 1, rtol: 1e-9}
"""
    found = exponents_of(linkages.loads(text), periods=40, skip=20, interval=8)
    assert found.values == pytest.approx([np.sqrt(9.81), -np.sqrt(9.81)], abs=2e-6)


@pytest.mark.slow_except("dop853", "tsit5", "rk4", "gauss8")
@pytest.mark.parametrize("method", METHODS)
def test_every_method_renormalises_tangents(method):
    """A damped pendulum at rest: exponents are the real parts of −c/2 ± √(c²/4 − g/l), c = 7.

    Neither intervals nor samples between are whole numbers of steps; what is wrong at a sample is
    made up for at the next one. Steps err by 1e-6 of the length of tangents, of which the shorter
    one keeps e^-2.5 within an interval.
    """
    text = SWINGING.replace("ANGLE", "-90 deg") + "dampers: [{joint: O, damping: 7}]\n"
    system = System(linkages.loads(text))
    step = 2e-3 if method in FIXED_STEP_METHODS else None
    tangents = LinkageTangents(system, 2, RunOptions(method=method, step=step), parts=3)
    found = lyapunov_spectrum(tangents, intervals=80, interval=0.50003, skip=10)
    root = np.sqrt(3.5**2 - 9.81)
    assert found.values == pytest.approx([root - 3.5, -root - 3.5], abs=2e-5)
    assert len(tangents.motion.time) == 3 * 90 + 1


@pytest.mark.slow
def test_fast_indicator_of_a_map_follows_one_tangent(monkeypatch):
    columns = []
    made = LinkageTangents.__init__

    def counted(self, system, tangents=1, *arguments, **options):
        columns.append(tangents)
        made(self, system, tangents, *arguments, **options)

    monkeypatch.setattr(LinkageTangents, "__init__", counted)
    axes = parse_range("free.upper.speed=0:0.1:2"), parse_range("free.lower.speed=0:0.1:2")
    for indicator, count in (("exponent", 1), ("fli", 1), ("gali", 2)):
        columns.clear()
        chaos_map(pendulum(3.0), *axes, indicator=indicator, periods=4, executor=Threads(1))
        assert columns == [count] * 4


def test_bifurcation_is_the_section_of_every_value():
    sizes = [1e-4, 2e-4, 3e-4]
    data = linkages.bifurcation(ninebar(), {"clearances.r1.size": sizes}, periods=5, skip=2)
    assert data.clearance_speed.dims == ("start", "value", "crossing", "clearance")
    for index, size in enumerate(sizes):
        alone = linkages.poincare(ninebar(**{"clearances.r1.size": size}), periods=5, skip=2)
        assert (data.clearance_speed[0, index] == alone.clearance_speed.to_numpy()).all()


def test_bifurcation_does_not_depend_on_the_number_of_cores():
    vary = {"drives.crank1.speed": np.linspace(-3, -2.5, 4),
            "drives.crank4.speed": np.linspace(3, 2.5, 4)}  # fmt: skip
    given = {"periods": 3, "skip": 0, "exponent": False}
    one, four = (
        linkages.bifurcation(ninebar(), vary, executor=Threads(n), **given) for n in (1, 4)
    )
    assert one.identical(four)


def test_continuation_goes_on_from_the_last_state():
    sizes = [1e-4, 1.2e-4]
    data = linkages.bifurcation(
        ninebar(), {"clearances.r1.size": sizes}, periods=3, skip=0, start="backward"
    )
    last = {
        "clearances.r1.size": sizes[0],
        "clearances.r1.angle": float(data.clearance_angle[0, 1, -1, 0]),
        "clearances.r1.speed": float(data.clearance_speed[0, 1, -1, 0]),
    }
    again = linkages.poincare(ninebar(**last), periods=3)
    assert data.clearance_speed[0, 0].to_numpy() == pytest.approx(again.clearance_speed.to_numpy())


def test_values_that_cannot_be_computed_do_not_stop_the_others():
    lengths = [0.3, 5.0, 0.31]
    data = linkages.bifurcation(ninebar(), {"bars.crank1.length": lengths}, periods=2, skip=0)
    assert "cannot be assembled" in str(data.reason[0, 1].item())
    assert np.isnan(data.clearance_angle[0, 1]).all()
    assert np.isfinite(data.clearance_angle[0, [0, 2]]).all()


def test_faults_of_the_program_are_not_swallowed():
    with pytest.raises(ZeroDivisionError):
        list(Threads().run(lambda value: 1 / value, [1, 0]))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("clearances.r1.size=0.01mm:0.5mm", "expected a range"),
        ("clearances.r1.size=0.01mm:0.5mm:1", "at least two"),
        ("clearances.r1.size=0.01mm:0.5m:9", "same unit"),
        ("0.01:0.5:9", "expected a range"),
    ],
)
def test_bad_ranges(text, words):
    with pytest.raises(ValueError, match=words):
        parse_range(text)


def test_ranges_with_units_in_lockstep():
    axes = [
        parse_range("drives.a.speed=-60 rpm:-30 rpm:4"),
        parse_range("drives.b.speed=60rpm:30rpm:4"),
    ]
    axis = together(axes)
    assert axis.at(3) == {"drives.a.speed": "-30.0 rpm", "drives.b.speed": "30.0 rpm"}


def test_map_of_initial_states():
    x = parse_range("clearances.r1.angle=-1:1:2")
    y = parse_range("clearances.r1.speed=0:100:2")
    data = chaos_map(ninebar(), x, y, indicator="fli", periods=5)
    assert data.indicator.shape == (2, 2)
    assert np.isfinite(data.indicator).all()
    assert set(data.rotation.to_numpy().ravel()) <= {"libration", "rotation", "mixed"}


def test_fast_indicator_of_a_map_belongs_to_the_whole_run():
    """With friction tangents become parallel soon; chaos is told by what grows afterwards."""
    axes = parse_range("free.upper.speed=0:0.1:2"), parse_range("free.lower.speed=0:0.1:2")
    shorter, longer = (
        chaos_map(pendulum(25.0), *axes, indicator="fli", periods=periods) for periods in (40, 80)
    )
    # λT to within the fluctuations of an exponent over 40 periods
    ratio = float(longer.indicator[0, 0]) / float(shorter.indicator[0, 0])
    assert ratio == pytest.approx(2, rel=0.2)


def test_contact_check_of_a_sine():
    time = np.linspace(0, 2 * np.pi, 1001)
    found = contact_check("r1", time, 0.5 + np.sin(time))
    assert found.share_lost == pytest.approx(1 / 3, abs=1e-4)  # sin < −1/2
    assert found.first_loss == pytest.approx(7 * np.pi / 6, abs=1e-4)
    assert (found.smallest, found.largest) == pytest.approx((-0.5, 1.5), abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "verdict"), [(0, "quasi-periodic"), ("90 deg", "chaotic")], ids=["0", "90 deg"]
)
def test_verdicts_of_the_nine_bar(angle, verdict):
    report = linkages.verdict(ninebar(**{"clearances.r1.angle": angle}), periods=200)
    assert report.verdict == report.tighter["verdict"] == verdict, report.reasons
    assert report.conservative
    exponent, error = (float(report.exponents[name][0]) for name in ("exponent", "error"))
    total = report.exponents.attrs["sum"], report.exponents.attrs["sum_error"]
    assert abs(total[0]) < max(1e-3, 4 * total[1])
    assert any("a real journal would leave" in reason for reason in report.reasons)
    if verdict == "chaotic":
        assert exponent > 4 * error
        assert 0.2 < exponent < 0.6  # reported: of the order 0.3…0.5 1/s
    else:
        history = report.exponents["history"][:, 0]
        assert float(history.sel(time=200.0, method="nearest")) < 0.1
        assert report.curves is not None
        assert report.curves.count >= 1
    json.dumps(report.to_dict())


@pytest.mark.slow
@pytest.mark.parametrize(("amplitude", "verdict"), [(15.0, "periodic"), (26.0, "chaotic")])
def test_verdicts_of_a_driven_damped_double_pendulum(amplitude, verdict):
    """Quasi-periodic motions coexist: those at amplitudes of 25 and 30 happen to end on one."""
    report = linkages.verdict(pendulum(amplitude), periods=400, skip=200)
    assert report.verdict == verdict, report.reasons
    assert not report.conservative
    assert report.exponents.attrs["sum"] < 0


@pytest.mark.slow
def test_slider_crank_with_two_clearances():
    mechanism = linkages.load("slider-crank", set=TWO_CLEARANCES)
    section = linkages.poincare(mechanism, periods=20)
    assert section.clearance_angle.shape == (20, 2)
    exponents = exponents_of(mechanism, periods=20, count=1)
    assert exponents.values[0] > 0


@pytest.mark.slow
def test_map_of_a_mechanism_with_two_clearances():
    mechanism = linkages.load("slider-crank", set=TWO_CLEARANCES)
    x = parse_range("clearances.a.angle=-1:1:3")
    y = parse_range("clearances.b.angle=-1:1:2")
    data = chaos_map(mechanism, x, y, indicator="fli", periods=4)
    assert np.isfinite(data.indicator).all()
    assert list(data.coordinate.to_numpy()) == ["a", "b"]
    assert data.rotation.shape == (2, 3, 2)
    assert (data.rotation != "").all()


def test_a_tangent_that_is_all_but_lost_does_not_hold_steps_up():
    """One that has shrunk by e³³ beside the others is round-off, and fits no accelerations.

    With those of before, two steps of five were rejected; now it is one of ten.
    """
    mechanism = linkages.load("double-pendulum").with_values(
        {"dampers": [{"joint": "P", "damping": 5}]}
    )
    tangents = LinkageTangents(System(mechanism), 4, RunOptions(rtol=1e-9, method="dop853"))
    for growth in tangents.grow(40, 0.5):
        lengths = 0.5 * growth.rates[:, -1]
    assert lengths.max() < -25
    cost = tangents.march.cost
    assert cost["rejected"] < 0.2 * cost["steps"]
