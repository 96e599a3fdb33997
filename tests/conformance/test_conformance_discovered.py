"""What is discovered automatically is complete: documentation, description, units, invariants.

Everything of a kind is enumerated, so nothing of it can be added half. Contact and friction laws:
`tests/contact`; keys and schema of components: `tests/components` and `tests/docs`.
"""

import inspect
import re
from dataclasses import FrozenInstanceError, fields
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

import linkages
from linkages.analyses import analyses, options_of_analysis
from linkages.components.mechanisms.registry import components
from linkages.exports import Subject, exports, files_of
from linkages.kernel.outputs import VARIABLES
from linkages.options.option import OptionError
from linkages.solution.series import available
from linkages.spec.models import documented_fields
from linkages.spec.units import unit

DOCS = Path(__file__).parents[2] / "docs"
SHIPPED = sorted(file.stem for file in (DOCS.parent / "mechanisms").glob("*.yaml"))
HAS_THE_REST = """
joints: {O: [0, 0], G: [1, 0], K: [2, 0]}
bars: {arm: {joints: [O, P], length: 1, mass: 1}, shaft: {joints: [G, Q], length: 0.1}}
sliders:
  follower: {joint: F, through: G, angle: 90 deg, mass: 0.1}
  block: {joint: B, through: K, mass: 1, inertia: 0.01}
  ball: {joint: M, through: O, mass: 1}
cams:
  - slider: follower
    bar: shaft
    angles: [0, 60 deg, 120 deg, 180 deg, 240 deg, 360 deg]
    lifts: [0, 3 mm, 6 mm, 3 mm, 1 mm, 0]
    base_radius: 18 mm
drives: {shaft: {angle: 0, speed: 3}}
maxwell: [{bar: arm, stiffness: 5 N*m/rad, damping: 0.4 N m s/rad}]
stops:
  - {bars: [ground, arm], lower: -80 deg, restitution: 0.5}
  - {slider: ball, lower: -1, restitution: 0.5}
clearances:
  play: {slider: block, size: 1 mm, length: 100 mm, height: 50 mm,
         contact: hunt-crossley-constant, stiffness: 1e9 N/m^1.5, dissipation: 1.5 s/m}
free: {arm: {angle: -30 deg}, block: {position: 0.1}, ball: {position: 0}}
"""
"""What no shipped mechanism has: a cam, an internal state, stops, a guide with clearance."""

MOVED_AT_A_POINT = """
joints: {O: [0, 0]}
sliders: {cart: {joint: S, through: O, mass: 3}}
bars: {arm: {joints: [S, P], length: 0.3, mass: 1}}
drives: {P: {x: 0.1 + 0.2*t, y: 0.2}}
actuators: {rail: {slider: cart}, swing: {bar: arm}}
assembly: {S: [-0.1, 0]}
"""
"""A point that a drive moves, with an actuator that turns and one that does not."""

DRIVEN_BY_A_LOAD = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1, mass: 1}}
gravity: [0, -9.81]
dampers: [{joint: O, damping: 0.2}]
loads: [{bar: arm, torque: "2*cos(3*t)"}]
free: {arm: {angle: -90 deg}}
"""
WEARS = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1, mass: 1}}
gravity: [0, -9.81]
free: {arm: {angle: -80 deg}}
clearances:
  gap: {joint: O, bar: arm, size: 0.1 mm, angle: -90 deg, pin_radius: 10 mm, width: 20 mm,
        wear: {bearing: {wear_rate: 1e-15}}}
"""


def described(function):
    """Names in the section of parameters of a docstring."""
    text = inspect.getdoc(function) or ""
    _, _, section = text.partition("Parameters\n----------\n")
    names = re.findall(r"^([\w*, ]+?)(?: :.*)?$", section.partition("\n\n")[0], re.MULTILINE)
    return {name.strip("* ") for line in names for name in line.split(",")}


# -- components -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", components())
def test_a_component_describes_all_of_its_fields(name):
    """Inherited ones as well: its docstring is its entry in the reference."""
    model = components()[name]
    assert {*documented_fields(inspect.getdoc(model))} >= {each.name for each in fields(model)}


@pytest.mark.parametrize("name", components())
def test_a_component_is_frozen_and_takes_its_fields_by_keyword_alone(name):
    model = components()[name]
    with pytest.raises(ValidationError) as caught:
        model(1)
    assert (0,) in {error["loc"] for error in caught.value.errors()}
    with pytest.raises(ValidationError, match=r"colour\n *Unexpected keyword argument"):
        model(colour="red")
    made = object.__new__(model)  # of no valid fields
    with pytest.raises(FrozenInstanceError):
        setattr(made, fields(model)[0].name, 1)


# -- outputs ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def computed():
    """Output → an array of it, of a mechanism that has it."""
    found = {}
    for made in [
        *map(linkages.load, SHIPPED),
        *map(linkages.loads, (HAS_THE_REST, WEARS, MOVED_AT_A_POINT)),
    ]:
        names = {*available(linkages.simulate(made, end=0.01, samples=2).system)}
        if missing := sorted(names - found.keys()):
            data = linkages.simulate(made, end=0.01, samples=5, outputs=missing).data
            found |= {name: data[name] for name in missing}
    return found


@pytest.mark.parametrize("name", VARIABLES)
def test_an_output_is_computed_with_its_dimensions_and_units(name, computed):
    """Its row in the documentation is compared by `tests/docs`."""
    entry, array = VARIABLES[name], computed[name]
    assert array.dims == ("time", *entry.dims)
    assert array.sizes["time"] == 5
    assert all(array[dim].size for dim in entry.dims)
    assert np.isfinite(array).all() or entry.reciprocal or entry.unbounded
    assert array.attrs["long_name"]
    for each in array.attrs["units"].split(" or "):
        assert each in ("1", "") or unit(each.replace("1/", "").replace(" ", "*"))
    assert entry.rate == "" or VARIABLES[entry.rate].dims == entry.dims
    assert entry.compared == "" or entry.compared in VARIABLES


# -- analyses ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", analyses())
def test_an_analysis_has_a_command_a_page_and_described_options(name):
    analysis = analyses()[name]
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")
    assert f"`{name.replace('_', '-')}`" in page
    mechanism, *options = inspect.signature(analysis).parameters.values()
    assert mechanism.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD
    assert {one.kind for one in options} <= {inspect.Parameter.KEYWORD_ONLY}
    assert {type(one.default) for one in options} <= {int, float, str, bool, type(None)}
    assert described(analysis) >= {one.name for one in options}
    assert options_of_analysis(name) == [one.name for one in options]
    assert getattr(linkages, name) is analysis


@pytest.mark.parametrize("name", analyses())
def test_an_analysis_returns_the_same_labelled_data_again(name):
    made = linkages.loads(DRIVEN_BY_A_LOAD)
    one, other = (analyses()[name](made) for _ in range(2))
    assert one.identical(other)
    for array in one.data_vars.values():
        assert array.attrs["long_name"]
        assert "units" in array.attrs
    assert one.attrs["name"] == made.name


# -- exports ----------------------------------------------------------------------------------


@pytest.mark.parametrize("to", exports())
def test_a_format_has_a_row_and_described_options(to):
    function = exports()[to]
    page = (DOCS / "exports.md").read_text(encoding="utf-8")
    heads = [line.split("|")[1] for line in page.splitlines() if line.startswith("| `")]
    assert f"`{to}`" in " ".join(heads)
    subject, *options = inspect.signature(function).parameters
    assert subject == "subject"
    assert described(function) >= {*options}


@pytest.mark.parametrize("to", exports())
def test_a_format_writes_the_same_named_files_again(to):
    if to == "dxf":
        pytest.importorskip("ezdxf")
    made = linkages.load("slider-crank")
    one, other = (dict(files_of(Subject(made, "taken", None), to, {})) for _ in range(2))
    assert one
    assert all(name.startswith("taken") and content for name, content in one.items())
    # DXF states when it was written
    assert one.keys() == other.keys() if to == "dxf" else one == other
    with pytest.raises(OptionError, match=r"has no option 'colour'"):
        files_of(Subject(made, "taken", None), to, {"colour": "red"})
