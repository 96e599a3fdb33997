"""A group solved by Newton's iteration over many steps: what is carried along does not drift."""

import numpy as np
import pytest
from stress_mechanisms import CLOSURE, defined, energy_of

import linkages
from linkages.kernel.system import System
from linkages.reading.document import find
from linkages.solution.plan import build_flow
from linkages.solvers import Outcome, integrate

TEXT = find("class-three").read_text(encoding="utf-8")
FREE = TEXT.replace(
    "drives:\n  crank: {angle: 0, speed: 60 rpm}", "free: {crank: {angle: 0, speed: 12}}"
)
LEGS = {"leg1": ("A", "E", 0.23), "leg2": ("C", "F", 0.15), "leg3": ("D", "G", 0.21)}
SIDES = {("E", "F"): 0.2, ("E", "G"): np.hypot(0.09, 0.16), ("F", "G"): np.hypot(0.11, 0.16)}
OUTPUTS = ["closure_residual", "joint_position", "bar_angle", "kinetic_energy", "potential_energy"]


def stretches(data):
    """Largest change of a distance that is rigid."""
    places = {str(j): data.joint_position.sel(joint=j).to_numpy() for j in data.joint.to_numpy()}
    pairs = {(a, b): length for a, b, length in LEGS.values()} | SIDES
    return max(
        float(np.abs(np.hypot(*(places[b] - places[a]).T) - length).max())
        for (a, b), length in pairs.items()
    )


def test_it_is_free():
    assert System(defined(FREE)).topology.free == ("crank",)
    assert System(defined(FREE)).topology.carried == ("leg1", "leg2", "leg3", "plate")


@pytest.mark.slow_except("rk4*")
@pytest.mark.parametrize(("method", "step"), [("rk4", 1e-4), ("gauss8", 1e-4)])
def test_hundred_thousand_steps(method, step):
    """Some twenty turns with equal steps: positions close as at the start, energy as the method."""
    end = 12.0 if method == "rk4" else 10.5
    solution = linkages.simulate(
        defined(FREE), end=end, samples=2001, method=method, step=step, outputs=OUTPUTS
    )
    assert solution.motion.cost["steps"] > 100_000
    assert float(solution.data.closure_residual.max()) <= CLOSURE
    assert stretches(solution.data) < 1e-15 * 4
    # h⁴ resp. round-off over 1e5 steps of some 0.5 J
    energy = np.abs(energy_of(solution.data))
    assert energy.max() < {"rk4": 1e-9, "gauss8": 1e-11}[method]


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dop853", "tsit5"])
def test_hundred_thousand_adaptive_steps(method):
    end = 400.0 if method == "tsit5" else 1000.0
    solution = linkages.simulate(
        defined(FREE), end=end, samples=2001, method=method, rtol=1e-11, outputs=OUTPUTS
    )
    assert solution.motion.cost["steps"] > 100_000
    assert float(solution.data.closure_residual.max()) <= CLOSURE
    assert stretches(solution.data) < 1e-15 * 4
    assert np.abs(energy_of(solution.data)).max() < 1e-4


def test_driven_over_many_turns():
    """Nothing is free, and what is carried along repeats itself turn by turn to a rounding."""
    data = linkages.simulate(defined(TEXT), end=200.0, samples=2001, outputs=OUTPUTS).data
    assert float(data.closure_residual.max()) <= CLOSURE
    per_turn = data.joint_position.to_numpy()[:2000].reshape(200, 10, -1)
    # the crank's angle itself is known to an ulp of 1257 rad
    assert np.ptp(per_turn, axis=0).max() < 1e-12
    # legs and plate swing: no whole turns creep in
    for bar in ("leg1", "leg2", "leg3", "plate"):
        assert float(np.ptp(data.bar_angle.sel(bar=bar).to_numpy())) < np.pi


@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5", "rk4", "gauss8"])
def test_what_is_carried_is_what_was_found(method):
    """After a step the carried part of the state is the solution, not the integral, of its rates.

    A step of 5 ms with an order-4 method is off by more than the iteration is.
    """
    system = System(defined(FREE))
    flow = build_flow(system)
    step = {"rk4": 5e-3, "gauss8": 5e-3}.get(method)
    found = integrate(flow, system.state, [0.0, 1.0], method=method, rtol=1e-4, step=step)
    assert found.outcome is Outcome.DONE
    n, first = flow.coordinates, flow.first_carried
    state = found.final_state
    known = state.copy()
    settled = system.evaluate(system.model.settled, 1.0, known[:, None])[:, 0]
    carried = flow.carried
    assert state[first : first + carried] == pytest.approx(settled[:carried], abs=1e-13)
    assert state[n + first :] == pytest.approx(settled[carried:], abs=1e-11)


def test_forward_and_back_again():
    system = System(defined(FREE))
    flow = build_flow(system)
    there = integrate(flow, system.state, [0.0, 5.0], method="vern9", rtol=1e-12)
    back = integrate(flow, there.final_state, [5.0, 0.0], method="vern9", rtol=1e-12)
    assert there.outcome is back.outcome is Outcome.DONE
    assert back.final_state == pytest.approx(system.state, abs=1e-7)
