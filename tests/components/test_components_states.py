"""Equations of states: closed forms, SciPy on equations by hand, analyses, messages."""

import numpy as np
import pytest
from component_reading import complaints, component
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import linkages
from linkages.chaos.common_period import common_period
from linkages.components.contributed.state_laws import InternalState
from linkages.components.state_equations import StateEquation
from linkages.equations import derive, render
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.orbits.orbit import orbit
from linkages.spec.formulas import Constant, formula
from linkages.spec.units import unit

WHEEL = """
joints: {O: [0, 0]}
bars: {wheel: {points: {O: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}}
free: {wheel: {angle: 0.5, speed: 1}}
parameters: {tau: 0.05 s, gain: 0.3}
states:
  filtered: {initial: 2 rad/s, rate: (wheel.speed - filtered.value)/tau}
  summed: {rate: 3*filtered.value - 0.4*summed.value}
loads: [{bar: wheel, torque: 0.5 - gain*filtered.value - 0.01*summed.value}]
"""
MATRIX = np.array(
    [[0, 1, 0, 0], [0, 0, -0.3 / 0.02, -0.01 / 0.02], [0, 20, -20, 0], [0, 0, 3, -0.4]]
)
DRIVEN = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.1, mass: 1}}
drives: {crank: {law: 0.3*sin(5*t)}}
states: {lag: {initial: 0.2 rad, rate: (crank.angle - lag.value)/0.05 s}}
"""
CYLINDER = """
joints: {O: [0, 0]}
sliders: {piston: {joint: P, through: O, angle: 0, mass: 20}}
free: {piston: {position: 0.05, speed: 0}}
parameters:
  {area: 1.2e-3 m^2, bulk: 1.4e9 Pa, dead: 2e-4 m^3, supply: 100 bar, soft: 0.1 bar,
   orifice: 5e-7 m^2, density: 870 kg/m^3, leak: 1e-12 m^3/s/Pa}
states:
  oil:
    initial: 20 bar
    rate: bulk/(dead + area*piston.position)*(orifice*sqrt(2/density)*(supply - oil.value)
          /sqrt(sqrt((supply - oil.value)**2 + soft**2)) - leak*oil.value - area*piston.velocity)
dampers: [{slider: piston, damping: 3000}]
springs: [{slider: piston, stiffness: 2e5, position: 0}]
loads: [{slider: piston, force: area*oil.value}]
"""


def cylinder(_, y):
    """The equations of `CYLINDER`: oil through an orifice, compressed under a piston."""
    place, speed, pressure = y
    drop = 1e7 - pressure
    flow = 5e-7 * np.sqrt(2 / 870) * drop / (drop**2 + 1e4**2) ** 0.25
    gained = flow - 1e-12 * pressure - 1.2e-3 * speed
    pushed = (1.2e-3 * pressure - 3000 * speed - 2e5 * place) / 20
    return [speed, pushed, 1.4e9 / (2e-4 + 1.2e-3 * place) * gained]


def test_same_from_yaml_and_python():
    made = StateEquation(
        name="filtered", initial=Constant(2.0, unit("rad/s")),
        rate=formula("(wheel.speed - filtered.value)/tau"),
    )  # fmt: skip
    assert component(WHEEL, "states", "filtered") == made
    mechanism = linkages.loads(WHEEL)
    assert linkages.loads(mechanism.to_yaml()) == mechanism
    (term,) = made.terms()
    assert isinstance(term, InternalState)
    assert (term.name, term.unit, term.scale) == ("states.filtered", "rad/s", 2.0)
    assert replaced_scale("scale: 5 rad/s") == 5.0
    assert replaced_scale("initial: 0 rad/s") == 1.0


def replaced_scale(entry):
    text = WHEEL.replace("initial: 2 rad/s", f"initial: 0 rad/s, {entry}".split(", initial")[0])
    if "scale" not in entry:
        text = WHEEL.replace("initial: 2 rad/s", entry)
    return linkages.loads(text).internal["states.filtered"].scale


def test_a_filter_behind_a_driven_crank():
    """τ ż = A sin ωt − z in a closed form; nothing else is integrated."""
    data = linkages.simulate(linkages.loads(DRIVEN), end=1, samples=11).data
    t, tau, rate = data.time.to_numpy(), 0.05, 5.0
    forced = 0.3 / (1 + (rate * tau) ** 2) * (np.sin(rate * t) - rate * tau * np.cos(rate * t))
    expected = forced + (0.2 - forced[0]) * np.exp(-t / tau)
    # rtol 1e-10 of 0.3 rad
    assert data.internal_state.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-10)
    assert data.internal.to_numpy().tolist() == ["states.lag"]
    assert data.internal_state.attrs["units"] == "rad"


@pytest.mark.slow_except("*dop853*")
@pytest.mark.parametrize("method", [("dop853", None), ("radau", None), ("gauss8", 0.005)], ids=str)
def test_states_of_states_in_a_loop(method):
    """Against the exponential of the matrix; without units a state is in SI."""
    names = ("bar_angle", "bar_speed", "internal_state", "internal_state_rate")
    data = linkages.simulate(
        linkages.loads(WHEEL), end=1, samples=11, method=method[0], step=method[1], outputs=names
    ).data
    rest = np.linalg.solve(MATRIX[1:, 1:], [-0.5 / 0.02, 0, 0])
    start = np.array([0.5, 1, 2, 0])
    shifted = start - np.array([0, *rest])
    expected = np.array([expm(MATRIX * t) @ shifted + [0, *rest] for t in data.time.to_numpy()])
    expected[:, 0] += rest[0] * data.time.to_numpy()
    found = np.hstack([data[name].to_numpy() for name in names])
    assert found[:, :4] == pytest.approx(expected, abs=2e-8)  # rtol 1e-10, growing with time
    rates = expected[:, 1:] @ MATRIX[2:, 1:].T
    assert found[:, 4:] == pytest.approx(rates, abs=1e-6)
    assert data.internal_state_rate.attrs["units"] == "rad/s/s or 1/s"


def test_a_hydraulic_cylinder_against_scipy():
    data = linkages.simulate(linkages.loads(CYLINDER), end=0.5, samples=6, rtol=1e-11).data
    own = solve_ivp(
        cylinder, (0, 0.5), [0.05, 0, 2e6], t_eval=data.time, rtol=1e-12, atol=1e-12,
        method="DOP853",
    ).y  # fmt: skip
    assert data.internal_state.to_numpy()[:, 0] == pytest.approx(own[2], rel=1e-10)
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(own[0], rel=1e-10)


def test_exponents_of_a_hydraulic_cylinder():
    """At rest in the end: real parts of eigenvalues, though states differ by 10 decades."""
    mechanism = linkages.loads(CYLINDER)
    data = linkages.lyapunov(mechanism, periods=100, interval=0.05, skip=100)
    end = solve_ivp(cylinder, (0, 20), [0.05, 0, 2e6], rtol=1e-11, atol=1e-11, method="Radau")
    steps = np.diag([1e-6, 1e-6, 10.0])
    columns = [
        (np.array(cylinder(0, end.y[:, -1] + step)) - cylinder(0, end.y[:, -1] - step))
        / (2 * step.max())
        for step in steps
    ]
    expected = np.sort(np.linalg.eigvals(np.array(columns).T).real)[::-1]
    # a turning pair, seen for 5 s
    assert data.exponent.to_numpy() == pytest.approx(expected, abs=0.05)
    rest = linkages.equilibrium(mechanism)
    assert rest["state"].sel(coordinate="states.oil").item() == pytest.approx(
        end.y[2, -1], rel=1e-9
    )


def test_an_orbit_has_the_multipliers_of_its_states():
    """A forced wheel behind a filter: e^(λT) of the matrix."""
    text = WHEEL.replace("torque: 0.5 -", 'torque: "cos(4*t) - wheel.angle -').replace(
        "summed.value}]", 'summed.value"}]'
    )
    mechanism = linkages.loads(text)
    assert common_period(mechanism) == pytest.approx(np.pi / 2, rel=1e-12)
    matrix = MATRIX.copy()
    matrix[1, 0] = -1 / 0.02
    data = orbit(mechanism)
    found = data["multiplier"].to_numpy() @ np.array([1, 1j])
    expected = np.exp(np.linalg.eigvals(matrix) * np.pi / 2)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(expected), rel=1e-7, abs=1e-9)
    assert data.attrs["stable"] == 1


def test_sensitivities_by_numbers_of_a_state():
    """Of a linear filter: by its initial value e^(−t/τ), by τ in a closed form."""
    text = DRIVEN.replace("law: 0.3*sin(5*t)", "law: 0.3").replace("/0.05 s", "/tau")
    mechanism = linkages.loads(text + "parameters: {tau: 0.05 s}\n")
    found = linkages.sensitivities(
        mechanism, "internal_state", ["states.lag.initial", "parameters.tau"], end=0.2, samples=5
    )
    t = found.time.to_numpy()
    by_start, by_tau = np.moveaxis(found["internal_state"].to_numpy().squeeze(), 0, 0).T
    assert by_start == pytest.approx(np.exp(-t / 0.05), abs=1e-9)
    assert by_tau == pytest.approx((0.2 - 0.3) * t / 0.05**2 * np.exp(-t / 0.05), abs=1e-8)


def test_printed_equations_are_those_of_the_kernel():
    system = System(linkages.loads(CYLINDER))
    module = {}
    exec(compile(render(derive(system.topology), "python"), "equations.py", "exec"), module)
    state = np.array([0.07, 0.0, 0.3, 5e6])
    own = system.evaluate(system.model.internal_rates, 0.0, state[:, None])[0, 0]
    assert own == pytest.approx(cylinder(0, [0.07, 0.3, 5e6])[2], rel=1e-13)
    assert module["internal_rates"](0.0, [0.07], [0.3], [5e6])[0] == pytest.approx(own, rel=1e-13)


def test_jumps_of_a_rate_are_located():
    """A relay with an integrator: z′ = −sign(z − ½) reaches ½ and slides along it."""
    text = DRIVEN.replace("(crank.angle - lag.value)/0.05 s", "-2*sign(lag.value - 0.5)").replace(
        "0.2 rad", "0.9"
    )
    data = linkages.simulate(linkages.loads(text), end=1, samples=11).data
    expected = np.maximum(0.9 - 2 * data.time.to_numpy(), 0.5)
    assert data.internal_state.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-12)


def test_a_sweep_has_the_bits_of_single_runs():
    mechanism = linkages.loads(WHEEL)
    measure = {"peak": "max(wheel.speed)"}
    swept = linkages.sweep(mechanism, {"states.filtered.initial": [1, 2, 3]}, measure, end=1)
    made = (mechanism.with_values({"states.filtered.initial": v}) for v in (1, 2, 3))
    single = [linkages.measure(linkages.simulate(one, end=1), measure["peak"]) for one in made]
    assert swept["peak"].to_numpy().tolist() == single


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("(wheel.speed - filtered.value)/tau", "wheel.speed*tau"),
         "line 7, column 32, states.filtered.rate: expected a rate of 'filtered' (1/s^2), found "
         "'wheel.speed*tau': it is an angle or a pure number"),
        (("3*filtered.value", "3*filterd.value"),
         "unknown state 'filterd'; did you mean 'filtered'? (character 3"),
        (("3*filtered.value", "3*filtered.speed"), "unknown body 'filtered'"),
        (("0.4*summed.value}", "0.4*rate(summed.value)}"),
         "'rate' expects a position, an angle or a distance"),
        (("3*filtered.value", "(3"), "expected a number, a quantity such as crank.angle"),
        (("initial: 2 rad/s", "initial: 2 rad/s, scale: 0"), "scale: expected a value > 0"),
        (("initial: 2 rad/s", "initial: 2 rad/s, scale: 1 N"),
         "scale: expected an angular speed (rad/s), found a force (N)"),
        (("initial: 2 rad/s", "scale: 1 N"), "has a unit; expected one of 'initial' as well"),
        (("rate: 3*filtered.value - 0.4*summed.value", "initial: 1"), "missing key 'rate'"),
    ],
    ids=lambda value: value[1] if isinstance(value, tuple) else "",
)  # fmt: skip
def test_bad_input(change, message):
    found = complaints(WHEEL.replace(*change))
    assert any(message in each for each in found), found


def test_drives_do_not_follow_states():
    text = DRIVEN.replace("0.3*sin(5*t)", "lag.value")
    assert "a drive prescribes a motion as a function of time alone" in complaints(text)[0]


def test_a_rate_without_a_value():
    text = DRIVEN.replace("(crank.angle - lag.value)/0.05 s", "sqrt(crank.angle - 0.1)")
    with pytest.raises(linkages.InputError, match=r"states\.lag: its law has no finite value at"):
        linkages.simulate(linkages.loads(text), end=1)
    text = DRIVEN.replace("(crank.angle - lag.value)/0.05 s", "-sqrt(lag.value - 0.1)*5 - 1")
    with pytest.raises(ComputationError, match=r"states\.lag \(its law has no finite value\)"):
        linkages.simulate(linkages.loads(text), end=1)
