"""Sweeps vary the mechanism that they are given, whether it comes from a file or from Python."""

from pathlib import Path

import pytest

import linkages
from linkages.chaos.maps import chaos_map
from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.reading.paths import dotted
from linkages.sweeps.axes import axis, axis_of, parse_range

SHIPPED = sorted((Path(__file__).parents[2] / "mechanisms").glob("*.yaml"))

PENDULUM = """\
name: Driven pendulum
gravity: [0, -1]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1, mass: 1}}
dampers: [{joint: O, damping: 0.5}]
loads: [{bar: arm, torque: {harmonic: {amplitude: 1.15, angular_frequency: 0.667}}}]
free: {arm: {angle: -1.2, speed: 0}}
simulate: {end: 10, samples: 101, rtol: 1e-8}
"""
AMPLITUDE = "loads[0].torque.harmonic.amplitude"


def pendulum():
    return linkages.loads(PENDULUM)


def in_python(mechanism):
    """The same components without any file."""
    return Mechanism(components=mechanism.components, name=mechanism.name, source=mechanism.source)


def numeric_paths(node, path=()):
    """Dotted paths of all numbers of a definition, with the numbers."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield from numeric_paths(value, (*path, str(key)))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from numeric_paths(value, (*path, index))
    elif isinstance(node, int | float) and not isinstance(node, bool):
        yield dotted(path), node


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_mechanism_made_in_python_has_the_definition_of_its_file(path):
    loaded = linkages.load(path)
    again = from_document(in_python(loaded).definition)
    assert again.components == loaded.components


@pytest.mark.slow_except("four-bar", "five-bar", "ninebar")
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_varying_is_loading_with_another_number(path):
    """Every number of every shipped file; defaults that follow from it follow."""
    loaded = linkages.load(path)
    made = in_python(loaded)
    numbers = dict(numeric_paths(made.definition.content))
    assert numbers
    for where, number in numbers.items():
        value = number + 1 if isinstance(number, int) else 1.01 * number
        expected = linkages.load(path, set={where: value}).components
        assert loaded.with_values({where: value}).components == expected
        assert made.with_values({where: value}).components == expected, where


LAWS = """\
joints: {O: [0, 0], C: [1, 0]}
bars: {a: {joints: [O, P], length: 1, mass: 1}, b: {joints: [C, Q], length: 1, mass: 1}}
drives:
  a: {law: {rise: cycloidal, from: 1, to: 2, duration: 3}}
  b: {law: {run-up: {speed: 60 rpm, duration: 2}}}
loads:
  - {bar: a, torque: "2*sin(3*t) + abs(t - 1)"}
  - {joint: Q, force: [{table: {times: [0, 1, 2], values: [1, 2, 1], periodic: true}}, 30 N]}
  - {bar: b, torque: {harmonic: {amplitude: 1, frequency: 2, phase: 30 deg}}}
"""


def test_laws_are_written_as_they_are_read():
    read = linkages.loads(LAWS)
    assert from_document(in_python(read).definition).components == read.components


def test_tables_of_other_files_are_found_from_anywhere(tmp_path, monkeypatch):
    (tmp_path / "torque.csv").write_text("t,T\n0,0\n1,0.2\n2,0\n")
    file = tmp_path / "m.yaml"
    law = "{table: {file: torque.csv, periodic: true}}"
    file.write_text(
        PENDULUM.replace("{harmonic: {amplitude: 1.15, angular_frequency: 0.667}}", law)
    )
    read = linkages.load(file)
    monkeypatch.chdir("/")
    length = {"bars.arm.length": 2.0}
    expected = linkages.load(file, set=length).components
    assert read.with_values(length).components == expected
    assert in_python(read).with_values(length).components == expected
    moved = read.with_state({"arm": (0.7, 3.0)}).with_values(length)
    assert moved.loads == read.with_values(length).loads


CHANGES = {
    "component": lambda m: m.with_component(linkages.JointDamper(index=5, joint="O", damping=5.0)),
    "state": lambda m: m.with_state({"arm": (0.7, 3.0)}),
    "in Python": in_python,
    "both": lambda m: in_python(m.with_state({"arm": (0.7, 3.0)})),
}


@pytest.mark.slow_except("*-in Python", "*-both")
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
@pytest.mark.parametrize("start", ["same", "forward"])
def test_a_sweep_keeps_what_was_changed_in_python(change, start):
    changed = change(pendulum())
    run = {"periods": 3, "skip": 2}
    data = linkages.bifurcation(changed, {AMPLITUDE: [1.15, 1.2]}, start=start, **run)
    alone = linkages.poincare(changed, **run).bar_speed.to_numpy()
    assert (data.bar_speed[0, 0].to_numpy() == alone).all()
    plain = linkages.poincare(pendulum(), **run).bar_speed.to_numpy()
    assert (alone == plain).all() == (change is in_python)
    assert data[AMPLITUDE].attrs["units"] == "N m"


def test_a_map_keeps_what_was_changed_in_python():
    axes = parse_range("free.arm.angle=0:1:2"), parse_range(f"{AMPLITUDE}=1:1.2:2")
    heavy = CHANGES["component"](pendulum())
    written = pendulum().with_values(
        {"dampers": [{"joint": "O", "damping": d} for d in (0.5, 5.0)]}
    )
    found, expected, plain = (
        chaos_map(m, *axes, periods=4).indicator.to_numpy() for m in (heavy, written, pendulum())
    )
    assert (found == expected).all()
    assert (found != plain).all()


def test_a_sweep_of_an_ideal_mechanism_has_no_clearances():
    clear = pendulum().with_values({"clearances": {"c": {"joint": "O", "bar": "arm", "size": 0.1}}})
    ideal = clear.ideal()
    data = linkages.bifurcation(ideal, {AMPLITUDE: [1.15, 1.2]}, periods=2, skip=0)
    assert "clearance_angle" not in data
    assert (data.bar_speed[0, 0] == linkages.poincare(pendulum(), periods=2).bar_speed).all()
    assert data.attrs["name"] == "Driven pendulum (ideal)"


def test_simulation_settings_go_with_the_mechanism():
    fast = pendulum().with_values({"simulate.rtol": 1e-5, "simulate.method": "tsit5"})
    changed = in_python(fast).with_state({"arm": (0.7, 3.0)})
    again = changed.with_values({"bars.arm.length": 2})
    assert (again.simulation.rtol, again.simulation.method) == (1e-5, "tsit5")
    assert again.initial["arm"].position == 0.7
    assert again.bodies["arm"].inertia.value == pytest.approx(4 / 12)  # m L²/12


def test_the_order_of_components_stays():
    """Free coordinates, and with them columns of results, stand where they stood."""
    components = in_python(linkages.load("double-pendulum")).components[::-1]
    made = Mechanism(components=components)
    found = made.with_values({"gravity[1]": -1.0})
    assert [c.path for c in found.components] == [c.path for c in made.components]


def test_paths_that_name_nothing_are_refused_in_python_too():
    with pytest.raises(InputError, match="did you mean 'length'"):
        in_python(pendulum()).with_values({"bars.arm.lenght": 1.0})
    with pytest.raises(InputError, match=r"expected a length > 0.*found '?-1"):
        in_python(pendulum()).with_values({"bars.arm.length": -1.0})


def test_lines_stay_with_what_still_stands_in_the_file():
    changed = pendulum().with_state({"arm": (0.7, 3.0)})
    assert changed.problem(("dampers", 0, "damping"), "…").line == 5
    assert changed.problem(("free", "arm", "angle"), "…").line == 7  # its section


def test_indices_close_up():
    """What is called dampers[1] is the second damper, also after the first one is gone."""
    more = pendulum().with_component(linkages.JointDamper(index=7, joint="O", damping=2.0))
    assert [c.path for c in more.components if c.section == "dampers"] == [
        ("dampers", 0), ("dampers", 1)
    ]  # fmt: skip
    changed = more.with_values({"dampers[1].damping": 3.0})
    assert [c.damping for c in changed.components if c.section == "dampers"] == [0.5, 3.0]


def test_values_may_be_texts_or_quantities_with_a_unit():
    import pint

    texts = axis({"bars.arm.length": ["900 mm", "1000 mm"]})
    assert (texts.values.tolist(), texts.unit) == ([[900.0, 1000.0]], "mm")
    quantity = axis({"bars.arm.length": pint.Quantity([900.0, 1000.0], "mm")})
    assert (quantity.values.tolist(), quantity.unit) == ([[900.0, 1000.0]], "millimeter")
    several = axis_of(["bars.arm.length=1:2:3", "free.arm.speed=3:4:3"])
    assert several.paths == ("bars.arm.length", "free.arm.speed")
    plain, given = (
        chaos_map(pendulum(), {"bars.arm.length": lengths}, {AMPLITUDE: [1.0, 1.2]}, periods=4)
        for lengths in ([0.9, 1.0], ["900 mm", "1000 mm"])
    )
    assert given["bars.arm.length"].attrs["units"] == "mm"
    # 900 mm is 0.9 m up to round-off
    assert given.indicator.to_numpy() == pytest.approx(plain.indicator.to_numpy(), rel=1e-6)


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"bars.arm.length": ["900 mm", "1 m"]}, "bars.arm.length: its values need the same unit"),
        ({"bars.arm.length": ["long", "1 m"]}, "bars.arm.length: expected numbers, or texts"),
        ({"bars.arm.length": 1.0}, "bars.arm.length: expected numbers, or texts"),
        ({"a": ["1 mm", "2 mm"], "b": [1, 2]}, "that vary together need the same unit"),
    ],
)
def test_values_that_do_not_go_together_are_named(vary, message):
    with pytest.raises(ValueError, match=message):
        axis_of(vary)
