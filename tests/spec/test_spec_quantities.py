import math
import os
import re
import subprocess
import sys
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from linkages.reading.output_files import ENVIRONMENT_VARIABLE
from linkages.spec import units
from linkages.spec import units as d
from linkages.spec.quantities import (
    ARITHMETIC,
    AccelerationVector,
    Duration,
    Length,
    Mass,
    Name,
    NameRule,
    Point,
    PositiveInteger,
    PositiveLength,
    Quantity,
    QuantityError,
    Tolerance,
    parse_quantity,
)


@pytest.mark.parametrize(
    ("value", "dimension", "expected"),
    [
        (0.3, d.LENGTH, 0.3),
        (2, d.LENGTH, 2.0),
        (Fraction(1, 4), d.LENGTH, 0.25),
        ("0.15 mm", d.LENGTH, 0.15e-3),
        ("35 mm", d.LENGTH, 0.035),
        ("-12cm", d.LENGTH, -0.12),
        ("4 µm", d.LENGTH, 4e-6),
        ("1 in", d.LENGTH, 0.0254),
        ("(1 + 2)/4 m", d.LENGTH, 0.75),
        ("20 deg", d.ANGLE, math.radians(20)),
        ("20°", d.ANGLE, math.radians(20)),
        ("2*pi/3 rad", d.ANGLE, 2 * math.pi / 3),
        ("pi/2", d.ANGLE, math.pi / 2),
        ("30 rpm", d.ANGULAR_SPEED, math.pi),
        ("30 spm", d.ANGULAR_SPEED, math.pi),
        ("30 1/min", d.FREQUENCY, 0.5),
        ("-1.5*pi rad/s", d.ANGULAR_SPEED, -1.5 * math.pi),
        ("−pi", d.ANGULAR_SPEED, -math.pi),
        ("36 km/hour", d.SPEED, 10.0),
        ("9.81 m/s**2", d.ACCELERATION, 9.81),
        ("9.81 m/s²", d.ACCELERATION, 9.81),
        ("9.81 m s^-2", d.ACCELERATION, 9.81),
        ("5 N*m", d.TORQUE, 5.0),
        ("5 N·m", d.TORQUE, 5.0),
        ("5 kN", d.FORCE, 5000.0),
        ("2 g*cm²", d.INERTIA, 2e-7),
        ("4530 N/m", d.STIFFNESS, 4530.0),
        ("5 N*m", d.TORSIONAL_STIFFNESS, 5.0),
        ("5 N*m/deg", d.TORSIONAL_STIFFNESS, 5 / math.radians(1)),
        ("5 N*s/m", d.DAMPING, 5.0),
        ("5 N*m*s", d.TORSIONAL_DAMPING, 5.0),
        ("5 N*m/(rad/s)", d.TORSIONAL_DAMPING, 5.0),
        ("3 ms", d.DURATION, 0.003),
        ("2 min", d.DURATION, 120.0),
        ("1e-10", d.NUMBER, 1e-10),
    ],
)
def test_values_in_si(value, dimension, expected):
    # One rounding for the number and one for the unit.
    assert parse_quantity(value, dimension) == pytest.approx(expected, rel=4e-16, abs=0)


@pytest.mark.parametrize(
    ("value", "dimension", "remedy"),
    [
        ("12 ton", d.MASS, "t: 1000 kg, short_ton: 907.185 kg, long_ton: 1016.05 kg"),
        ("12 tons", d.MASS, "t: 1000 kg"),
        ("3 kton", d.MASS, "t: 1000 kg"),
        ("2 ton_force", d.FORCE, "tf: 9806.65 N"),
        ("1 cwt", d.MASS, "long_hundredweight: 50.8023 kg"),
        ("1 kcal", d.TORQUE, "cal_th: 4.184 J"),
        ("30 grad", d.ANGLE, "gon: turn/400, deg: turn/360"),
        ("30 Grad", d.ANGLE, "deg: turn/360"),  # a gigaradian otherwise
        ("3 mil", d.ANGLE, "thou: 25.4 µm, mrad: 0.001 rad"),
        ("3 mils", d.LENGTH, "thou: 25.4 µm"),
    ],
)
def test_units_with_several_meanings_are_refused(value, dimension, remedy):
    """Twelve tons are 10886, 12000 or 12193 kg."""
    found = refusal(value, dimension)
    assert "has several meanings; expected one of " in found
    assert remedy in found


@pytest.mark.parametrize("meanings", units._SEVERAL.values())
def test_remedies_for_units_with_several_meanings_are_units_of_that_size(meanings):
    for remedy in meanings.split(", "):
        name, _, size = remedy.partition(": ")
        if size and "/" not in size:
            number, of = size.split()
            assert units.unit(name).exponents == units.unit(of).exponents
            assert units.unit(name).scale == pytest.approx(
                units.unit(of).convert(float(number)), rel=5e-6
            )
        else:
            assert units.unit(name)


@pytest.mark.parametrize("name", [name for own in units.COMMON.values() for name in own])
def test_common_units_are_those_of_pint(name):
    assert units.unit(name) == units.named_by_pint(name)


@given(st.integers(-(10**6), 10**6))
def test_whole_millimetres_are_the_nearest_double(count):
    assert parse_quantity(f"{count} mm", d.LENGTH) == count / 1000


def refusal(value, dimension, bound=d.Bound.NONE):
    with pytest.raises(QuantityError) as caught:
        parse_quantity(value, dimension, bound)
    return str(caught.value)


LENGTH = "expected a length (metres, or with a unit), found "


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("3 kg", LENGTH + "'3 kg': kg is a mass, not a length"),
        (
            "5 milimeter",
            LENGTH + "'5 milimeter': unknown unit 'milimeter'; did you mean 'millimeter'?",
        ),
        ("5 MM", LENGTH + "'5 MM': MM is not a unit of length; did you mean 'mm'?"),
        ("5 rad", LENGTH + "'5 rad': rad is an angle, not a length"),
        ("0,15", LENGTH + "'0,15': decimals are written with a point"),
        ("2^3", LENGTH + "'2^3': powers are written **"),
        (True, LENGTH + "True"),
        (None, LENGTH + "nothing"),
        ([1], LENGTH + "a list of 1"),
        ({}, LENGTH + "a mapping"),
        (math.inf, LENGTH + "inf: not a finite number"),
        (math.nan, LENGTH + "nan: not a finite number"),
        (10**400, None),
        ("1e400", LENGTH + "'1e400': too large for a number"),
        ("1e300 Ym", LENGTH + "'1e300 Ym': not a finite number"),
        ("nan", LENGTH + "'nan': expected a number before 'nan'"),
        ("20 degC", None),
        ("3 dB", None),
        ("3 m*dB", None),
        ("5 m)", None),
        ("5 (m", None),
        ("5 m**1.5", None),
        ("5 m**999999", None),
        ("5 " + "m*" * 500 + "m", None),
        ("5 ((Ym**9)**9)", None),
        ("5 ym**9*ym**9*m", None),
        ("5 __class__", None),
        ("5 m; import os", None),
        ("5 m\n6", None),
        ("5 kg\n*m", None),
        ("x" * 10**6, None),
        ("", None),
    ],
)
def test_what_is_no_length(value, message):
    found = refusal(value, d.LENGTH)
    assert found == message or (message is None and found.startswith(LENGTH))
    assert len(found) < 250
    assert "\n" not in found


@pytest.mark.parametrize(
    ("value", "dimension", "reason"),
    [
        ("5 Hz", d.ANGULAR_SPEED, "Hz is a frequency, not an angular speed: write rad/s or rpm"),
        ("5 1/s", d.ANGULAR_SPEED, "1/s is a frequency, not an angular speed: write rad/s or rpm"),
        ("5 deg", d.ANGULAR_SPEED, "deg is an angle, not an angular speed"),
        ("5 deg", d.NUMBER, "this number has no unit"),
        ("5 percent", d.ANGLE, "percent is not a unit of angle"),
        ("2pi", d.ANGLE, "write the product as *pi"),
        ("-90*1e30 deg", d.ANGLE, "beyond 1e+08 rad its direction is lost in rounding"),
        ("5 milimeter", d.LENGTH, "unknown unit 'milimeter'; did you mean 'millimeter'?"),
        ("5 Nm", d.TORQUE, "did you mean 'N*m'?"),
        ("5 N", d.TORQUE, "N is a force, not a torque"),
        ("5 N/m", d.TORSIONAL_STIFFNESS, "N/m is a stiffness, not a torsional stiffness"),
        ("20 degC", d.LENGTH, "degC has its zero elsewhere"),
    ],
)
def test_units_of_something_else(value, dimension, reason):
    assert reason in refusal(value, dimension)


def test_integer_that_python_refuses_to_print():
    assert refusal(10**5000, d.LENGTH).endswith("too large for a number")


def test_bounds():
    assert refusal("-12 cm", d.LENGTH, d.Bound.POSITIVE) == (
        "expected a length > 0 (metres, or with a unit), found '-12 cm'"
    )
    assert refusal(0, d.LENGTH, d.Bound.POSITIVE).endswith("found 0")
    assert parse_quantity(0, d.LENGTH, d.Bound.NON_NEGATIVE) == 0.0


def read(kind, value):
    return TypeAdapter(kind).validate_python(value)


@pytest.mark.parametrize(
    ("kind", "value", "expected"),
    [
        (PositiveInteger, "2001", 2001),
        (PositiveInteger, "2*10**3 + 1", 2001),
        (PositiveInteger, 5, 5),
        (Tolerance, "1e-10", 1e-10),
        (Point, ["1.1", 0], (1.1, 0.0)),
        (AccelerationVector, ["0", "-9.81 m/s²"], (0.0, -9.81)),
        (Mass, "0", 0.0),
        (Duration, "2 s", 2.0),
        (Name, "link 3-a_b", "link 3-a_b"),
        (Name, "Kurbel_ü", "Kurbel_ü"),
        (Name, "7", "7"),
    ],
)
def test_field_types(kind, value, expected):
    result = read(kind, value)
    assert result == expected
    assert type(result) is type(expected)


@pytest.mark.parametrize(
    ("kind", "value", "message"),
    [
        (PositiveInteger, "0", "expected a whole number > 0, found '0'"),
        (PositiveInteger, "1.5", "expected a whole number > 0, found '1.5'"),
        (PositiveInteger, "many", "expected a whole number > 0, found 'many': expected a number"),
        (Tolerance, "0", "expected a number > 0, found '0'"),
        (Mass, "-1", "expected a mass >= 0 (kilograms, or with a unit), found '-1'"),
        (Length, "{x}", "found '{x}'"),
    ],
)
def test_field_types_refuse(kind, value, message):
    with pytest.raises(ValidationError) as caught:
        read(kind, value)
    assert message in caught.value.errors()[0]["msg"]


@pytest.mark.parametrize(
    "name",
    ["", " a", "a ", "a.b", "a[0]", "a'b", 'a"b', "a\nb", "a\n", "a\tb", "-a", "x" * 65, None, 1],
)
def test_names_that_would_break_paths_or_messages(name):
    with pytest.raises(ValidationError, match="expected a name \\(letters, digits"):
        read(Name, name)


def test_json_schema():
    assert TypeAdapter(PositiveLength).json_schema() == {
        "description": "a length > 0 (metres, or with a unit)",
        "type": ["number", "string"],
        "exclusiveMinimum": 0,
        "pattern": ARITHMETIC,
    }
    assert TypeAdapter(Name).json_schema()["type"] == ["string", "integer"]
    assert TypeAdapter(PositiveInteger).json_schema()["minimum"] == 1


TEXTS = st.text(st.sampled_from("0.5eE+-−*/() \tpiπmkgb°1²"), max_size=8)


@given(TEXTS)
def test_pattern_of_numbers_refuses_nothing_that_is_read(text):
    """What `schema` says of a text is necessary: an editor never marks what the loader reads."""
    try:
        Quantity(d.LENGTH).read(text)
    except QuantityError:
        return
    assert re.search(ARITHMETIC, text)


@pytest.mark.slow
@given(st.text(max_size=5) | st.text(st.sampled_from("aé_- .1"), max_size=8))
def test_pattern_of_names_refuses_nothing_that_is_a_name(text):
    try:
        NameRule().read(text)
    except QuantityError:
        return
    assert re.search(NameRule().json_schema()["pattern"], text)


def test_plain_numbers_do_not_import_pint():
    code = (
        "import sys; from linkages.spec.quantities import *; from linkages.spec.units import *;"
        "parse_quantity('-1.5*pi', LENGTH);"
        "sys.exit(bool({'pint', 'numpy', 'llvmlite', 'networkx'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.slow_except("0.5")
@pytest.mark.parametrize("rest", [0.0, 0.5, 0.99], ids=str)
def test_units_that_another_process_is_writing(rest, tmp_path, monkeypatch):
    """Pint writes its cache in place: who reads meanwhile, or after a crash, finds a part of it."""
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))
    fresh = units._registry.__wrapped__
    assert fresh().Quantity(1, "inch").to("metre").magnitude == 0.0254
    kept = [*(tmp_path / "units").glob("*.pickle")]
    assert kept
    for path in kept:
        content = path.read_bytes()
        path.write_bytes(content[: int(rest * len(content))])
    assert fresh().Quantity(1, "inch").to("metre").magnitude == 0.0254


@pytest.mark.skipif(os.name == "nt", reason="permissions of POSIX")
def test_units_that_others_may_have_written_are_not_read(tmp_path, monkeypatch):
    """They are pickles, which can run anything."""
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))
    (tmp_path / "units").mkdir()
    (tmp_path / "units").chmod(0o777)
    assert units._registry.__wrapped__().Quantity(1, "inch").to("metre").magnitude == 0.0254
    assert not [*(tmp_path / "units").iterdir()]


@pytest.mark.parametrize(
    ("text", "plain"),
    [("300 kg mm2", "300 kg*mm**2"), ("5 g cm2", "5 g*cm^2"), ("0.5 kg m2", "0.5 kg*m²")],
)
def test_powers_without_a_sign_as_drawing_programs_print_them(text, plain):
    read = Quantity(d.INERTIA).read
    assert read(text) == read(plain)
    assert Quantity(d.ACCELERATION).read("9.81 m/s2") == 9.81


@pytest.mark.parametrize("text", ["1 kg mm5", "1 kg mm1", "1 kg xy2", "1 kg mm22"])
def test_other_digits_are_no_powers(text):
    with pytest.raises(QuantityError, match="unknown unit"):
        Quantity(d.INERTIA).read(text)
