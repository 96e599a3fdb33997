"""From an entry of a definition to its term, for entries that contribute one term each."""

import ast

from linkages.components.contributed.functions import (
    Function,
    Number,
    Operation,
    Table,
    Time,
    V,
    X,
    constant,
    linear,
)
from linkages.components.contributed.load_measures import (
    Coordinate,
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
)
from linkages.components.contributed.terms import (
    ZERO,
    Body,
    Guide,
    Parameter,
    PointMass,
    Prescribed,
    Relation,
)

OPERATIONS = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "div", ast.Pow: "power"}


def _number(path: tuple, value: float, structural: bool = True) -> Parameter:
    return Parameter(path, float(value), structural=structural)


def function(path: tuple, text: str | float | dict) -> Function:
    """A formula in t (and in x and v, of a law of state), a table, or a number."""
    if isinstance(text, dict):
        table = text["table"]
        return Table(path, tuple(table["times"]), tuple(table["values"]), table["periodic"])
    if not isinstance(text, str):
        return Number(_number(path, text))
    return _translated(ast.parse(text, mode="eval").body)


def _translated(node: ast.expr) -> Function:
    match node:
        case ast.Constant(value=value):
            return constant(float(value))
        case ast.Name(id="t"):
            return Time()
        case ast.Name(id="x" | "v" as name):
            return X if name == "x" else V
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return Operation("neg", (_translated(operand),))
        case ast.BinOp(op=op, left=left, right=right):
            return Operation(OPERATIONS[type(op)], (_translated(left), _translated(right)))
        case ast.Call(func=ast.Name(id="abs"), args=[argument]):
            return Operation("abs", (_translated(argument),))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return Operation(name, tuple(_translated(argument) for argument in arguments))
    raise ValueError(ast.dump(node))


def _pair(path: tuple, place: tuple[float, float]) -> tuple[Parameter, Parameter]:
    x, y = (_number((*path, index), value) for index, value in enumerate(place))
    return x, y


def _slider(path: tuple, entry: dict) -> Body:
    origin = entry.get("through", (0.0, 0.0))
    if not isinstance(origin, str):
        origin = _pair((*path, "through"), origin)
    angle = _number((*path, "angle"), entry.get("angle", 0.0), structural=False)
    further = entry.get("points", {}).items()
    return Body(
        name=path[1],
        kind="slider",
        path=path,
        points={entry["joint"]: (ZERO, ZERO)}
        | {joint: _pair((*path, "points", joint), place) for joint, place in further},
        mass=_number((*path, "mass"), entry.get("mass", 0.0)),
        inertia=_number((*path, "inertia"), entry.get("inertia", 0.0)),
        guide=Guide(origin, angle, entry.get("on")),
    )


def _drive(path: tuple, entry: dict) -> Prescribed:
    if "law" in entry:
        return Prescribed(path[1], function((*path, "law"), entry["law"]), path)
    start = next(key for key in ("angle", "position") if key in entry)
    numbers = [_number((*path, key), entry[key], structural=False) for key in (start, "speed")]
    return Prescribed(path[1], linear(*numbers), path)


def _load(path: tuple, entry: dict) -> Load | tuple[Load, Load]:
    """A given load, or any law along any measure, which no file can ask for."""
    if "law" in entry:
        return Load(_measure(entry), function((*path, "law"), entry["law"]), path)
    if "slider" in entry:
        force = function((*path, "force"), entry["force"])
        return Load(Slide(entry["slider"]), force, path, applied=True)
    if "joint" in entry:
        x, y = (
            Load(
                Coordinate(entry["joint"], axis),
                function((*path, "force", axis), value),
                path,
                applied=True,
            )
            for axis, value in enumerate(entry["force"])
        )
        return x, y
    torque = function((*path, "torque"), entry["torque"])
    first, second = entry.get("bars", ("ground", entry.get("bar")))
    return Load(Turn(second, _reference(first)), torque, path, applied=True)


def _reference(name: str) -> str | None:
    return None if name == "ground" else name


def _measure(entry: dict) -> Measure:
    if "slider" in entry:
        return Slide(entry["slider"])
    if "between" in entry:
        return Distance(*entry["between"])
    if "joint" in entry:
        return Coordinate(entry["joint"], entry["axis"])
    pair = entry.get("between_bars") or entry.get("bars") or ("ground", entry["bar"])
    return Turn(pair[1], _reference(pair[0]))


def _spring(path: tuple, entry: dict) -> Load:
    """A spring, or a damper, which is a spring without stiffness: −(k·(x − c) + d·v)."""

    def number(key: str) -> Function:
        return Number(_number((*path, key), entry.get(key, 0.0)))

    def times(factor: Function, of: Function) -> Function:
        return Operation("mul", (factor, of))

    measure = _measure(entry)
    relaxed = "angle" if isinstance(measure, Turn) else "length"
    deflection = Operation("sub", (X, number(relaxed)))
    parts = times(number("stiffness"), deflection), times(number("damping"), V)
    return Load(measure, Operation("neg", (Operation("add", parts),)), path)


def _mass(path: tuple, entry: float) -> PointMass:
    return PointMass(path[1], _number(path, entry), path)


def _gear(path: tuple, entry: dict) -> Relation:
    """θ_b = ratio·θ_a + (1 − ratio)·θ_carrier + angle."""
    (first, second), ratio = entry["bars"], entry["ratio"]
    parts = {first: ratio, entry.get("carrier", "ground"): 1.0 - ratio}
    numbers = (
        (name, _number((*path, "ratio", name), part, structural=False))
        for name, part in parts.items()
        if name != "ground"
    )
    return Relation(second, tuple(numbers), _number((*path, "angle"), entry["angle"]), path)


def _weld(path: tuple, entry: dict) -> Relation:
    return _gear(path, {**entry, "ratio": 1.0})


READERS = {
    "sliders": _slider,
    "drives": _drive,
    "loads": _load,
    "springs": _spring,
    "dampers": _spring,
    "masses": _mass,
    "gears": _gear,
    "welds": _weld,
}
