"""What acts on a mechanism and what ties angles together, in words: rows of `check`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import groupby
from typing import assert_never

import numpy as np

from linkages.components.contributed.functions import (
    Function,
    Measured,
    Number,
    Operation,
    Table,
    Time,
    extremes,
)
from linkages.components.contributed.load_measures import (
    GROUND,
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
    named,
)
from linkages.components.contributed.state_laws import (
    NOTHING,
    Monomial,
    addends,
    monomial,
    of_state,
    sum_of,
    variables,
)
from linkages.components.joint_clearances import ContactClearance, GuideClearance
from linkages.components.laws import NamedLaw, function_of
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at
from linkages.components.rigid_bodies import Weld
from linkages.components.transmissions import Cam, CamContact, Gear, Rack, Rope
from linkages.kernel.inputs import law_values
from linkages.reading.paths import KeyPath, dotted
from linkages.reading.wording import listed
from linkages.reports.report import number
from linkages.solution.remarks import law_range
from linkages.spec.formulas import Formula
from linkages.spec.models import written_fields

Row = dict[str, str]


def relations(mechanism: Mechanism) -> list[Row]:
    """Welds, gears, racks and ropes: ``kind, path, on, value``."""
    result: list[Row] = []
    for part in mechanism.components:
        if isinstance(part, Weld):
            value = f"at {part.name}, {number(math.degrees(part.angle))}°"
            result.append(_row("weld", value, part.path, " and ".join(part.bars)))
        elif isinstance(part, Gear):
            value = f"{part.bars[1]} turns {number(part.ratio)} times as fast as {part.bars[0]}"
            if part.carrier not in (None, GROUND):
                value += f", seen from {part.carrier}"
            result.append(_row("gear", value, part.path, " and ".join(part.bars)))
        elif isinstance(part, Rack):
            value = f"{part.slider} moves {number(part.radius)} m per radian of {part.bar}"
            if part.carrier not in (None, GROUND):
                value += f", seen from {part.carrier}"
            result.append(_row("rack", value, part.path, f"{part.bar} and {part.slider}"))
        elif isinstance(part, Cam):
            low, high = extremes(part.table, part.angles[0], part.angles[-1])
            value = f"{part.slider} is lifted by {number(low)} to {number(high)} m"
            result.append(_row("cam", value, part.path, f"{part.bar} and {part.slider}"))
        elif isinstance(part, Rope):
            first, second = part.sliders
            value = f"{second} moves {number(part.ratio)} times as fast as {first}"
            result.append(_row("rope", value, part.path, f"{first} and {second}"))
    return result


def drives(mechanism: Mechanism) -> list[Row]:
    """Drives and actuators: ``kind, path, on, value``, with the range of what is prescribed."""
    result = []
    for name, drive in mechanism.prescribed.items():
        unit = "rad" if mechanism.bodies[name].rotates else "m"
        match drive.law:
            case Operation("add", (Number(start), Operation("mul", (Number(speed), Time())))):
                value = f"{number(start.value)} {unit} at t = 0, {number(speed.value)} {unit}/s"
            case _:
                value = _law(drive.law, unit, mechanism)
        result.append(_row("drive", value, drive.path, name))
    for own in mechanism.actuations.values():
        moved = _on(Load(own.measure, NOTHING, own.path))
        result.append(_row("actuator", f"{own.name} makes the motion", own.path, moved))
    return result


def loads(mechanism: Mechanism) -> list[Row]:
    """Forces, torques, springs, dampers, masses at joints: ``kind, path, on, value``.

    Those that are exactly zero are left out, as they are of the equations. Laws of time are shown
    with their range.
    """
    result = []
    for (path, pushes), same in groupby(mechanism.loads, lambda load: (load.path, load.pushes)):
        parts = list(same)
        if parts[0].called:
            keys = _keys(mechanism, path)
            result += [_row(p.called, keys, path, _on(p)) for p in parts if not p.absent]
        elif pushes:  # both components of a force at a joint stand in one row
            result.append(_row(*_pushing(parts, mechanism), path, _on(parts[0])))
        else:
            result += [_row(*_passive(load), path, _on(load)) for load in parts if not load.absent]
    masses = [
        _row("mass", f"{number(m.mass.value)} kg", m.path, f"joint {m.joint}")
        for m in mechanism.point_masses
        if not m.mass.absent
    ]
    own = [*_contacts(mechanism), *_ends(mechanism), *_states(mechanism)]
    return [*result, *own, *masses]


def _states(mechanism: Mechanism) -> Iterator[Row]:
    """States with equations of their own: the initial value, and what the rate depends on."""
    for state in mechanism.states:
        start = f"initial {number(state.initial)} {state.unit}".rstrip()
        if state.period is None:
            law = f"rate {_law(state.law, f'{state.unit or 1}/s', mechanism)}"
        else:
            every = number(state.period.parameter.value)
            law = f"next {_law(state.law, state.unit, mechanism)} every {every} s"
        yield _row("state", f"{start}, {law}", state.path, str(state.path[-1]))


def _ends(mechanism: Mechanism) -> Iterator[Row]:
    """Where bodies bounce: the end, and how much they do."""
    for end in mechanism.ends:
        law = f"restitution {number(end.law.restitution.value)}"
        where = f"{'at most' if end.upper else 'at least'} {number(end.limit.value)}"
        unit = "rad" if end.twists else "m"
        on = _on(Load(end.measure, NOTHING, end.path, called="stop"))
        yield _row("stop", f"{where} {unit}, {law}", end.path, on)


def _contacts(mechanism: Mechanism) -> Iterator[Row]:
    """What presses in clearances that open and at walls: the law, and the numbers given."""
    for own in (*mechanism.opening, *mechanism.walls):
        keys = {"stiffness": f"N/m^{own.stiffness_exponent:g}", "dissipation": "s/m",
                "restitution": "", "damping": "N s/m", "viscosity": "Pa s", "width": "m",
                "friction": ""}  # fmt: skip
        given = ((key, getattr(own, key, None), unit) for key, unit in keys.items())
        numbers = (f"{k} {number(value)} {unit}".strip() for k, value, unit in given if value)
        if isinstance(own, ContactClearance):
            on = f"{own.bar} at {own.joint}, which has the {own.carries}"
        elif isinstance(own, GuideClearance):
            on = f"{own.slider} in its guide"
        elif isinstance(own, CamContact):
            on = f"{own.slider} on its cam, {own.bar}"
        else:
            on = f"{own.body} at {listed(own.points, 'and')}, and a wall of {own.wall}"
        yield _row("contact", ", ".join((own.contact, *numbers)), own.path, on)


def _on(load: Load) -> str:
    """What a load acts on."""
    match load.measure:
        case Distance(first, second):
            return f"joints {first} and {second}"
        case Turn(body, reference):
            return body if reference is None else f"{body} against {reference}"
        case Slide(body):
            return f"{body}, along its axis" if load.pushes else f"{body} in its guide"
        case Coordinate(joint, axis):
            return f"joint {joint}" if load.pushes else f"{'xy'[axis]} of joint {joint}"
        case BodyAxis(joint, body):
            return f"joint {joint}, turning with {body}"
        case _:
            assert_never(load.measure)


def _pushing(same: list[Load], mechanism: Mechanism) -> tuple[str, str]:
    """Kind and value of a force or torque; that at a joint has two components."""
    shown = ", ".join(_law(load.law, load.unit, mechanism, load.measure) for load in same)
    return "torque" if same[0].twists else "force", f"[{shown}]" if len(same) > 1 else shown


def _passive(load: Load) -> tuple[str, str]:
    """Kind and value of a spring or damper."""
    kind = "spring" if load.elastic else "damper"
    return f"torsional {kind}" if load.twists else kind, ", ".join(_terms(load))


def _terms(load: Load) -> Iterator[str]:
    """The numbers of terms that are constant or linear, and what all others depend on."""
    unit = load.unit
    per, relaxed = ("rad", "angle ") if load.twists else ("m", "length ")
    if isinstance(load.measure, Slide):
        relaxed = "position "
    damping = "" if isinstance(load.measure, Slide) else "damping "
    viscous: list[str] = []
    others: list[Function] = []
    for term in addends(load.force):
        match monomial(term):
            case Monomial(Operation("neg", (Number(k),)), Measured(), 1, 0):
                yield f"{number(k.value)} {unit}/{per}"
            case Monomial(Operation("neg", (Number(k),)), Operation("sub", (_, Number(c))), 1, 0):
                yield f"{number(k.value)} {unit}/{per}"
                yield f"{relaxed}{number(c.value)} {per}"
            case Monomial(Operation("neg", (Number(d),)), None, 0, 1):
                viscous.append(f"{damping}{number(d.value)} {unit} s/{per}")
            case _ if not variables(term):
                yield f"{number(float(law_values(term, np.zeros(1))[0]))} {unit}"
            case _:
                others.append(term)
    yield from viscous
    if others:
        yield f"a law of {listed(named(sum_of(others)), 'and')}"


def _keys(mechanism: Mechanism, path: KeyPath) -> str:
    """The numbers and laws of a component, as its entry in the definition has them."""
    component = next(c for c in mechanism.components if c.path == path)
    result = []
    for key, value in (written_fields(component) or {}).items():
        given = component.dimension_of(key)
        unit = given.unit if given else unit_at(mechanism.definition, dotted((*path, key)))
        match value:
            case float():
                result.append(f"{key} {number(value)} {unit}".rstrip())
            case Formula() | NamedLaw():
                result.append(f"{key} {_law(function_of(value, (*path, key)), unit, mechanism)}")
    return ", ".join(text.replace("_", " ") for text in result)


def _row(kind: str, value: str, path: KeyPath, on: str) -> Row:
    return {"kind": kind, "path": dotted(path), "on": on, "value": value}


def _law(function: Function, unit: str, mechanism: Mechanism, own: Measure | None = None) -> str:
    """The range of a law over time, or what else it depends on; `own` is what x and v are of."""
    if isinstance(function, Number):
        return f"{number(function.parameter.value)} {unit}"
    if of_state(function):
        of = listed(named(function, own), "and")
        if not isinstance(function, Table):
            return f"a law of {of}"
        low, high = extremes(function, function.places[0], function.places[-1])
        return f"{number(low)} to {number(high)} {unit} over {of}"
    end = mechanism.simulation.end
    result = law_range(function, end)
    over = f"until t = {number(end)} s"
    if result.period is not None:
        over = f"in each period of {number(result.period)} s"
    return f"{number(result.low)} to {number(result.high)} {unit} {over}"
