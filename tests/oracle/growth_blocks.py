"""Blocks that slide on the ground, on bars or on other blocks, and the frames of their axes."""

import cmath

from growing_mechanisms import Growing, xy


def slider(g: Growing, joint: str, place: complex, axis: float, **more: str) -> tuple[str, float]:
    """A block at a joint that is at a place of the frame that carries its axis.

    Returns its name and its displacement.
    """
    name, position = g.name("s", "sliders"), g.draw.number(-1.0, 1.0)
    origin = place - cmath.rect(position, axis)
    entry = {"joint": joint, "through": xy(origin), "angle": axis, "mass": g.draw.number(0.0, 2.0)}
    if not more and g.chance(0.3):
        entry["through"] = g.ground_pin(origin)
    if more and g.chance(0.5):
        entry["inertia"] = g.draw.number(0.0, 0.1)
    g.section("sliders")[name] = {**entry, **more}
    return name, position


def corner(g: Growing, block: str, direction: float) -> None:
    """One joint more on a block whose axis has a direction."""
    entry = g.section("sliders")[block]
    local = g.polar(0.1, 0.5)
    place = g.places[entry["joint"]] + local * cmath.exp(1j * direction)
    entry["points"] = {g.joint(place, hint=False): xy(local)}


def displaced(g: Growing, bar: str, joint: str) -> str | None:
    """What the point of a bar is called that a clearance takes off a joint."""
    clearances = g.definition.get("clearances", {}).items()
    found = (n for n, c in clearances if (c["bar"], c["joint"]) == (bar, joint))
    return next((f"{joint}.{name}" for name in found), None)


def own_points(g: Growing, bar: str) -> dict[str, complex]:
    """Points of a bar or plate in its own frame, under the names that the file gives them."""
    entry = g.definition["bars"][bar]
    if "points" in entry:
        return {joint: complex(*place) for joint, place in entry["points"].items()}
    return dict(zip(entry["joints"], (0j, complex(entry["length"])), strict=True))


def local_frame(g: Growing, bar: str) -> tuple[complex, complex]:
    """Origin of the frame of a bar, and the factor that turns vectors into the frame."""
    turn = cmath.exp(-1j * g.angles[bar])
    joint, local = next(iter(own_points(g, bar).items()))
    return g.places[displaced(g, bar, joint) or joint] - local / turn, turn
