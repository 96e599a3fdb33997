"""Random trees of bars and plates, most of them free, with all that acts on such bodies."""

from __future__ import annotations

import numpy as np
import yaml

import linkages


def tree(seed: int, count: int, rows: bool = False) -> linkages.Mechanism:
    """A tree of bodies; `rows`: one behind the other.

    Every fourth body is a plate with its centre of mass off the line of its joints, every fifth one
    is driven.
    """
    random = np.random.default_rng(seed)
    points, bars, drives, free = ["G0", "G1"], {}, {}, {}
    for i in range(count):
        start = points[-1] if rows and i else points[random.integers(len(points))]
        name, mass = f"b{i}", float(random.uniform(0.5, 2))
        if i % 4 == 3:
            ends = {start: [0, 0], f"P{i}": [0.3, 0.1], f"Q{i}": [-0.1, 0.4]}
            centre = random.uniform(-0.2, 0.2, 2).tolist()
            bars[name] = {"points": ends, "mass": mass, "center": centre, "inertia": 0.1}
            points += [f"Q{i}", f"P{i}"]
        else:
            length = float(random.uniform(0.2, 0.5))
            bars[name] = {"joints": [start, f"P{i}"], "length": length, "mass": mass}
            points.append(f"P{i}")
        angle, speed = random.uniform(-3, 3), random.uniform(-2, 2)
        if i % 5 == 4:
            drives[name] = {"law": f"{angle:.3f} + {speed:.3f}*t + 0.2*sin(3*t)"}
        else:
            free[name] = {"angle": float(angle), "speed": float(speed)}
    ends = [point for point in points if point[0] != "G"]
    definition = {
        "gravity": [1.5, -9.81],
        "joints": {"G0": [0, 0], "G1": [0.7, -0.2]},
        "bars": bars,
        "drives": drives,
        "free": free,
        "masses": {ends[3]: 0.4, ends[-1]: 0.7},
        "loads": [
            {"joint": ends[5], "force": [3, "2*cos(t)"]},
            {"joint": "P1", "on": "b1", "force": [0, -4]},
            {"bars": ["b1", "b2"], "torque": 0.5},
        ],
        "springs": [
            {"between": [ends[1], ends[7]], "stiffness": 30, "length": 0.3, "damping": 0.5},
            {"between": ["G1", ends[8]], "stiffness": 20, "length": 0.1},
            {"between_bars": ["b0", "b6"], "stiffness": 2, "angle": 0.3, "damping": 0.1},
            {"bar": "b5", "stiffness": 1},
        ],
        "dampers": [{"bars": ["ground", "b0"], "damping": 0.2}],
        "friction": [
            {"between_bars": ["b1", "b3"], "torque": 0.3, "slip_speed": 0.5},
            {"between_bars": ["b2", "b7"], "torque": 0.2},
        ],
    }
    return linkages.loads(yaml.safe_dump(definition, sort_keys=False))
