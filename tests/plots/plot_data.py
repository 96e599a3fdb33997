"""A mechanism with one of everything that is drawn, and made-up data for it."""

import numpy as np
import xarray as xr

import linkages
from linkages.components.mechanisms.mechanism import Mechanism

DEFINITION = """
name: Press
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.5, 0]}
bars:
  crank: {joints: [O, A], length: 0.1}
  coupler: {points: {A: [0, 0], B: [0.4, 0], P: [0.2, 0.15]}}
  rocker: {joints: [D, B], length: 0.3}
  rod: {joints: [P, F], length: 0.4}
sliders: {ram: {joint: F, through: [0.2, 0], angle: 90 deg}}
clearances: {r1: {joint: B, bar: rocker, size: 0.1 mm, angle: 0}}
drives: {crank: {angle: 0.5, speed: -pi}}
"""
JOINTS = {
    "O": (0.0, 0.0),
    "D": (0.5, 0.0),
    "A": (0.1, 0.0),
    "B": (0.45, 0.3),
    "B.r1": (0.4501, 0.3),
    "P": (0.25, 0.35),
    "F": (0.2, 0.7),
}
SERIES = {
    "slider_position": ("slider", "m", 0.25),
    "slider_velocity": ("slider", "m/s", 0.3),
    "slider_acceleration": ("slider", "m/s^2", 20.0),
    "slider_position_error": ("slider", "m", 8e-5),
    "slider_velocity_error": ("slider", "m/s", 0.02),
    "slider_acceleration_error": ("slider", "m/s^2", 8.0),
    "clearance_angle": ("clearance", "rad", 1.0),
    "clearance_speed": ("clearance", "rad/s", 200.0),
    "clearance_force": ("clearance", "N", 4e3),
    "drive_effort": ("drive", "N m", 30.0),
    "load_force": ("force", "N", 500.0),
    "load_torque": ("torque", "N m", 2.0),
    "bar_angle": ("bar", "rad", 1.0),
    "bar_speed": ("bar", "rad/s", 3.0),
}
NAMES = {
    "slider": ["ram"],
    "clearance": ["r1"],
    "drive": ["crank"],
    "force": ["loads[0]"],
    "torque": ["loads[2]"],
    "bar": ["crank", "coupler", "rocker", "rod"],
    "joint": list(JOINTS),
    "axis": ["x", "y"],
}


def press() -> Mechanism:
    return linkages.loads(DEFINITION)


def press_data(samples: int = 201, **more_names: list[str]) -> xr.Dataset:
    """Sines for every series; joints on small circles, ground joints at rest."""
    names = NAMES | more_names
    time = np.linspace(0.0, 2.0, samples)
    variables = {}
    for variable, (dimension, units, size) in SERIES.items():
        phases = np.arange(len(names[dimension]))
        values = size * np.sin(7.0 * time[:, None] + phases)
        variables[variable] = (("time", dimension), values, {"units": units})
    circle = 0.05 * np.column_stack((np.cos(3 * time), np.sin(3 * time)))
    moving = np.array([name not in ("O", "D") for name in JOINTS])
    places = np.array(list(JOINTS.values())) + circle[:, None, :] * moving[:, None]
    variables["joint_position"] = (("time", "joint", "axis"), places, {"units": "m"})
    return xr.Dataset(variables, {"time": time, **names})


def hopping_data(clearances: tuple[str, ...] = ("gap",), samples: int = 401) -> xr.Dataset:
    """A pin that flies for three quarters of the time, hits its hole twice, and then follows it."""
    time = np.linspace(0.0, 1.0, samples)
    size = 2e-4
    touching = (time >= 0.75) | (abs(time - 0.25) < 0.02) | (abs(time - 0.5) < 0.02)
    distance = np.where(touching, 1.01 * size, 0.6 * size)
    offset = distance[:, None] * np.column_stack((np.cos(5 * time), np.sin(5 * time)))
    state = np.where(time >= 0.75, 2, touching)
    names = list(clearances)
    each = (slice(None), None)
    along, pair = ("time", "clearance"), ("time", "clearance", "axis")
    return xr.Dataset(
        {
            "clearance_offset": (pair, np.stack([offset] * len(names), 1), {"units": "m"}),
            "clearance_indentation": (
                along, np.repeat((distance - size)[each], len(names), 1), {"units": "m"}
            ),
            "clearance_state": (along, np.repeat(state.astype(np.int8)[each], len(names), 1)),
        },
        {"time": time, "clearance": names, "axis": ["x", "y"]},
    )  # fmt: skip
