"""Results of the absolute formulation under the names of output variables (docs/outputs.md)."""

import numpy as np
from absolute_bodies import GROUND
from absolute_coordinates import AbsoluteModel, Solved


def outputs(model: AbsoluteModel, solved: Solved) -> dict[str, dict[str, np.ndarray]]:
    """Variable → element (bar, slider, …, joint) → value, a vector for joints."""
    state, bodies = solved.state, model.mechanism.bodies
    start = model.layout.start
    found: dict[str, dict[str, np.ndarray]] = {}
    for name, body in bodies.items():
        if body.rotates:
            kind, index = "clearance" if body.kind == "clearance" else "bar", start[name] + 2
            series = state.places[index], state.rates[index], solved.accelerations[index]
            suffixes = "angle", "speed", "acceleration"
        else:
            kind, series = "slider", model.coordinate_values(solved, name)
            suffixes = "position", "velocity", "acceleration"
        for suffix, value in zip(suffixes, series, strict=True):
            found.setdefault(f"{kind}_{suffix}", {})[name] = np.asarray(value)
    for joint, (point, *_) in model.layout.points.items():
        acceleration = state.jacobian(point) @ solved.accelerations + state.bias(point)
        series = state.place(point), state.velocity(point), acceleration
        for suffix, value in zip(("position", "velocity", "acceleration"), series, strict=True):
            found.setdefault(f"joint_{suffix}", {})[joint] = value
    found["joint_reaction"] = reactions(model, solved)
    found["pin_reaction"] = pin_reactions(model, solved)
    found["drive_effort"] = {c.label: e[0] for c, e in solved.efforts if c.kind == "drive"}
    found["clearance_force"] = clearance_forces(model, solved)
    return {name: values for name, values in found.items() if values}


def reactions(model: AbsoluteModel, solved: Solved) -> dict[str, np.ndarray]:
    """Force that the first body at each joint exerts on the others."""
    total = {joint: np.zeros(2) for joint in model.layout.points}
    for constraint, force in solved.efforts:
        if constraint.kind == "pin":
            total[constraint.label] = total[constraint.label] + force
    return total


def pin_reactions(model: AbsoluteModel, solved: Solved) -> dict[str, np.ndarray]:
    """Force of the others on each of three bodies or more that share a pin."""
    total: dict[str, dict[str, np.ndarray]] = {}
    for constraint, force in solved.efforts:
        if constraint.kind == "pin":
            pin = total.setdefault(constraint.label, {})
            first = model.layout.points[constraint.label][0].body or GROUND
            for body, change in ((first, -force), (constraint.second, force)):
                pin[body] = pin.get(body, np.zeros(2)) + change
    bars = {one.name: one.bar for one in model.mechanism.clearances}
    return {
        f"{joint}.{bars.get(body, body)}": force
        for joint, pin in total.items()
        for body, force in pin.items()
        if len(pin) > 2
    }


def clearance_forces(model: AbsoluteModel, solved: Solved) -> dict[str, np.ndarray]:
    """Tension of each massless link, from what acts on its displaced end."""
    found = {}
    for name, body in model.mechanism.bodies.items():
        if body.kind == "clearance":
            end = list(body.points)[1]
            (force,) = (
                effort
                for c, effort in solved.efforts
                if c.kind == "pin" and c.label == end and c.second == name
            )
            angle = solved.state.angle(name)
            found[name] = force @ np.array([np.cos(angle), np.sin(angle)])
    return found


def ground_force(model: AbsoluteModel, solved: Solved) -> np.ndarray:
    """Resultant of everything that the ground exerts through pins and guides."""
    total = np.zeros(2)
    for constraint, effort in solved.efforts:
        body = constraint.label
        if constraint.kind == "pin" and model.layout.points[body][0].body is None:
            total += effort
        guide = None if constraint.kind == "pin" else model.mechanism.bodies[body].guide
        if guide is not None and guide.body is None and constraint.kind in ("axis", "drive"):
            angle = guide.angle.value + (np.pi / 2 if constraint.kind == "axis" else 0.0)
            total += effort[0] * np.array([np.cos(angle), np.sin(angle)])
    return total


__all__ = ["GROUND", "clearance_forces", "ground_force", "outputs", "pin_reactions", "reactions"]
