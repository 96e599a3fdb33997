"""The table of closure errors after a minute on the first page and in README.md.

A Strandbeest leg swings without a drive: Lagrange's equations in one free coordinate here, against
coordinates of all bodies with multipliers (index 1), integrated by the same method at the same
tolerance as they are and with Baumgarte's stabilisation, and against MuJoCo, if it is installed.
"""

from __future__ import annotations

import tempfile
from importlib.util import find_spec

import numpy as np
from scipy.integrate import solve_ivp

import linkages
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from make.registry import makes, table

END, RTOL = 60.0, 1e-8
RATE = 10.0  # of Baumgarte's stabilisation, 1/s: errors die away within tenths of a second
STEP = 1e-3  # of MuJoCo, half of what is usual


def leg() -> Mechanism:
    """Jansen's leg, its crank pushed at 12 rad/s and then left to itself."""
    changes = {"drives": {}, "free.m": {"angle": 0, "speed": 12.0}}
    return linkages.loads(linkages.load("jansen").to_yaml(), set=changes)


def own(mechanism: Mechanism) -> float:
    """Largest closure error here, in metres."""
    solution = linkages.simulate(
        mechanism, end=END, samples=6001, rtol=RTOL, method="dop853", outputs=["closure_residual"]
    )
    return float(solution.data.closure_residual.max())


def multipliers(mechanism: Mechanism, rate: float) -> float:
    """Largest closure error in metres, with Baumgarte's terms −2 c Φ̇ − c² Φ for a rate c."""
    from absolute_bodies import State  # of the tests
    from absolute_coordinates import AbsoluteModel

    model, system = AbsoluteModel(mechanism), System(mechanism)
    angles = {name: system.model.positions.angle(name) for name in mechanism.bodies}
    values = system.evaluate(list(angles.values()))[:, 0]
    places = model.configuration(system.places(), dict(zip(angles, values, strict=True)))
    begin = model.state(0.0, places, {"m": 12.0})
    half = model.layout.size

    def derivative(time: float, both: np.ndarray) -> np.ndarray:
        state = State(model.layout, time, both[:half], both[half:])
        accelerations = model.solve(state).accelerations
        if rate:
            phi = model.jacobian(state)
            pull = 2 * rate * phi @ state.rates + rate**2 * model.closure(state)
            accelerations = accelerations - np.linalg.pinv(phi) @ pull
        return np.concatenate([state.rates, accelerations])

    found = solve_ivp(
        derivative,
        (0.0, END),
        np.concatenate([begin.places, begin.rates]),
        method="DOP853",
        rtol=RTOL,
        atol=RTOL,
    )
    ends = (State(model.layout, 0.0, both[:half], both[half:]) for both in found.y.T)
    return max(float(np.abs(model.closure(state)).max()) for state in ends)


def mujoco_error(mechanism: Mechanism) -> float:
    """Largest distance of the points that MuJoCo should hold together, in metres."""
    import mujoco

    with tempfile.TemporaryDirectory() as folder:
        (path,) = linkages.export(mechanism, "mjcf", folder)
        model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = STEP
    data = mujoco.MjData(model)
    worst = 0.0
    for _ in range(round(END / STEP)):
        mujoco.mj_step(model, data)
        worst = max(worst, float(np.abs(data.efc_pos[: data.ne]).max()))
    return worst


@makes("constraint-error")
def errors() -> str:
    """What each formulation leaves."""
    mechanism = leg()
    found = {"`linkages`: closure in closed form, one free coordinate": own(mechanism)}
    for rate, words in ((0.0, ""), (RATE, f", Baumgarte's stabilisation, {RATE:g} 1/s")):
        name = f"coordinates of all bodies, Lagrange multipliers{words}"
        found[name] = multipliers(mechanism, rate)
    if find_spec("mujoco") is not None:
        words = f"MuJoCo, soft constraints, steps of {1e3 * STEP:g} ms"
        found[words] = mujoco_error(mechanism)
    lines = ((name, f"{error:.0e} m") for name, error in found.items())
    return table(("formulation", "largest closure error in a minute"), lines)
