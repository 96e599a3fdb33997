"""The JSON Schema accepts all that the loader accepts, and refuses for the loader's reasons."""

import json
from pathlib import Path

import jsonschema
import pytest
from yaml_as_editors_read_it import values

from linkages.cli.verbs.definition_commands import schema_text
from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.registry import FILE_NAME, SECTIONS, definition_schema
from linkages.errors import InputError
from linkages.reading.document import parse, shipped
from linkages.reading.paths import dotted

ROOT = Path(__file__).parents[2]
SCHEMA = definition_schema()
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)
TEMPLATES = sorted((ROOT / "linkages" / "cli" / "templates").glob("*.yaml"))
FILES = [*shipped().values(), *TEMPLATES]

FRAME = """\
joints: {O: [0, 0], D: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.15}
  coupler: {points: {A: [0, 0], B: [0.12, 0]}, mass: 0.4, center: [0.05, 0], inertia: 1e-4}
  rocker: {joints: [D, B], length: 0.08}
sliders: {piston: {joint: P, through: [0, 0], points: {Q: [0, 1 mm]}}}
"""
ACCEPTED = """\
name: 4
gravity: ['0', -9.81 m/s²]
joints: {1: [0, 0], D é-2: [(0.1 + 0)*1, −0 mm]}
bars:
  crank: {joints: [1, A], length: 2*pi/100, mass: 150 g, inertia: , center: [1 mm, 0]}
  coupler: {points: {A: [0, 0], B: [0.12, 0]}, mass: 0.4, center: [0.05, 0], inertia: "1e-4"}
  rocker: {joints: [D é-2, B], length: 0.08, center: 4 cm}
sliders: {piston: {joint: P, on: rocker, angle: 30°}}
clearances:
masses: {A: +.5, P: 2}
springs: [{bar: rocker, stiffness: 2 N*m}, {between: [1, B], stiffness: 1, length: 0}]
dampers: [{bars: [ground, rocker], damping: 0}, {slider: piston, damping: 1}]
drives:
  crank: {law: {run-up: {speed: 60 rpm, duration: 1 s, from: 3 deg}}}
  piston: {law: {table: {times: [0, 1, 2 s], values: [0, 1 mm, 0], periodic: on}}}
loads:
  - {bar: crank, torque: "max(0, t)"}
  - {joint: B, force: [t**2, {harmonic: {amplitude: 2, frequency: 3 Hz}}]}
  - {slider: piston, force: {rise: modified-sine, to: 3, duration: 1}}
assembly: {B: left}
simulate: {end: 1 s, samples: 1e3, change_points: pass}
"""

# What is wrong, and where it is.
REFUSED = [
    ("barz: {}", "barz"),
    ("gravity: [0]", "gravity"),
    ("gravity: down", "gravity"),
    ("gravity: [0, down]", "gravity[1]"),
    ("masses: {A: -1}", "masses.A"),
    ("masses: [1]", "masses"),
    ("masses: {A/B: 1}", "masses.'A/B'"),
    ("welds: {A: {bars: [crank], angle: 0}}", "welds.A.bars"),
    ("welds: {A: {bars: [crank, coupler]}}", "welds.A"),
    ("gears: {a: {bars: [crank, rocker], ratio: 2}}", "gears"),
    ("gears: [{bars: [crank, rocker], ratio: fast}]", "gears[0].ratio"),
    ("clearances: {gap: {joint: A, bar: coupler, size: 0}}", "clearances.gap.size"),
    ("clearances: {gap: {joint: A, bar: coupler, sise: 1}}", "clearances.gap.sise"),
    ("clearances: {gap: {joint: [A], bar: coupler, size: 1}}", "clearances.gap.joint"),
    ("drives: {crank: {angle: 0, speed: true}}", "drives.crank.speed"),
    ("drives: {crank: {law: {rise: linear, to: 1, duration: 1}}}", "drives.crank.law.rise"),
    ("drives: {crank: {law: {rise: cycloidal, to: 1}}}", "drives.crank.law"),
    ("drives: {piston: {position: 0, speed: 1, angle: 2}}", "drives.piston.angle"),
    ("loads: [{slider: piston, force: [1, 2]}]", "loads[0].force"),
    ("loads: [{joint: B, force: 3}]", "loads[0].force"),
    ("loads: [{bar: crank, force: 3}]", "loads[0].force"),
    ("springs: [{between: [A, B], stiffness: 3}]", "springs[0]"),
    ("dampers: [{joint: A, damping: -3}]", "dampers[0].damping"),
    ("assembly: {B: up}", "assembly.B"),
    ("simulate: {samples: 2.5}", "simulate.samples"),
    ("simulate: {change_points: skip}", "simulate.change_points"),
]


def everywhere(error):
    """All places that an error may be about: those of the alternatives that were tried, too."""
    extra = set(error.instance) - set(error.schema.get("properties", {})) if (
        error.validator == "additionalProperties"
    ) else ()  # fmt: skip
    yield from ((*error.absolute_path, key) for key in extra)
    if error.validator == "propertyNames" or error.parent is None or not error.context:
        yield tuple(error.absolute_path)
    if error.validator == "propertyNames" or "propertyNames" in error.absolute_schema_path:
        yield (*error.absolute_path, error.instance)
    for inner in error.context:
        yield from everywhere(inner)


def loader_refuses(text):
    try:
        from_document(parse(text, "m.yaml"))
    except InputError as error:
        return error.problems
    return ()


def test_schema_is_a_schema():
    jsonschema.Draft7Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_shipped_file_and_template_is_accepted(path):
    text = path.read_text(encoding="utf-8")
    VALIDATOR.validate(values(text))
    VALIDATOR.validate(parse(text, path.name).content)  # numbers as text are right as well


def test_all_forms_that_are_read_are_accepted():
    assert loader_refuses(ACCEPTED) == ()
    VALIDATOR.validate(values(ACCEPTED))


@pytest.mark.parametrize(("text", "place"), REFUSED)
def test_what_the_schema_refuses_the_loader_refuses_there(text, place):
    whole = f"{FRAME}{text}\n"
    found = list(VALIDATOR.iter_errors(values(whole)))
    assert place in {dotted(path) for error in found for path in everywhere(error)}
    assert place in [problem.path for problem in loader_refuses(whole)]


@pytest.mark.parametrize("section", SECTIONS)
def test_every_section_is_described_with_its_entries(section):
    about = SCHEMA["properties"][section]
    assert about["description"].endswith(SECTIONS[section].example) or "[" in about["description"]
    for model in SECTIONS[section].models:
        if SECTIONS[section].field is None:
            properties = SCHEMA["definitions"][model.__name__]["properties"]
            assert properties
            assert [key for key, part in properties.items() if not part["description"]] == []
            assert not {"name", "index"} & set(properties)


def test_description_of_a_key_says_meaning_form_and_unit():
    length = SCHEMA["definitions"]["Bar"]["properties"]["length"]
    assert length["description"] == (
        "Distance of the two joints in metres, > 0. "
        "Expected: a length > 0 (metres, or with a unit)."
    )


def test_shipped_schema_is_what_the_program_prints():
    """`python -m linkages schema > mechanisms/linkages.schema.json` makes it anew."""
    shipped_text = (ROOT / "mechanisms" / FILE_NAME).read_text(encoding="utf-8")
    assert json.loads(shipped_text) == SCHEMA
    assert shipped_text == schema_text() + "\n"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_file_names_its_schema(path):
    line = path.read_text(encoding="utf-8").splitlines()[0]
    assert line == f"# yaml-language-server: $schema={FILE_NAME}"
