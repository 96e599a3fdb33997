"""Tables of laws from CSV files beside the definition file."""

import math
import pickle

import pytest

import linkages
from linkages import InputError
from linkages.components.contributed.functions import X
from linkages.components.mechanisms.definition import from_document
from linkages.spec.law_fields import MAX_ROWS

DEFINITION = """\
joints: {O: [0, 0]}
bars: {a: {joints: [O, A], length: 1, mass: 1}}
free: {a: {angle: 0, speed: 0}}
loads:
  - {bar: a, torque: {table: {TABLE}}}
"""
CSV = "# measured\ntime;load;other\n0;1;9\n\n1;3;8\n2;2.5e0;7\n"


@pytest.fixture
def law(tmp_path):
    """Loads a definition with a table and a CSV file, gives the law of the load."""

    def loaded(table, csv=CSV, **more):
        data = csv if isinstance(csv, bytes) else csv.encode()
        (tmp_path / "gas.csv").write_bytes(data)
        file = tmp_path / "engine.yaml"
        file.write_text(DEFINITION.replace("TABLE", table))
        return linkages.load(file, **more).loads[0].law

    return loaded


@pytest.mark.parametrize("mark", [";", ",", "\t"])
@pytest.mark.parametrize("columns", ["", ", columns: [time, load]", ", columns: [1, 2]"])
def test_columns(law, mark, columns):
    found = law(f"file: gas.csv{columns}", CSV.replace(";", mark))
    assert (found.places, found.values) == ((0, 1, 2), (1, 3, 2.5))


def test_no_header_units_and_other_keys(law):
    table = "file: gas.csv, columns: [1, 3], units: [ms, kN*m], interpolation: linear"
    found = law(table, "\ufeff0,1,-9\r\n1,3,8\r\n2,2,−9\r\n")
    assert found.places == pytest.approx((0, 1e-3, 2e-3), rel=1e-15)
    assert found.values == pytest.approx((-9e3, 8e3, -9e3), rel=1e-15)
    assert found.interpolation == "linear"


def test_over_another_quantity(law):
    """The first column holds places on its axis, in its units."""
    table = "file: gas.csv, over: a.angle, units: [deg, N*m], periodic: true, interpolation: linear"
    found = law(table, "angle,torque\n0,5\n90,7\n360,5\n")
    assert found.places == pytest.approx((0, math.pi / 2, 2 * math.pi), rel=1e-15)
    assert (found.values, found.turning) == ((5, 7, 5), True)
    assert found.over == X
    with pytest.raises(
        InputError, match=r"at\[0\]: .* is an angle or a pure number, and this is a"
    ):
        law(table.replace("deg", "mm"), "0,5\n90,7\n360,5\n")
    with pytest.raises(InputError, match=r"line 2: expected increasing places$"):
        law(table, "90,5\n0,7\n360,5\n")


def test_over_another_quantity_it_is_written_out_and_read_again(tmp_path):
    (tmp_path / "gas.csv").write_text("0,5\n90,7\n360,5\n")
    table = "file: gas.csv, over: sin(a.angle) + 1 rad*2, units: [deg, N*m]"
    (tmp_path / "engine.yaml").write_text(DEFINITION.replace("TABLE", table))
    mechanism = linkages.load(tmp_path / "engine.yaml")
    assert linkages.loads(mechanism.to_yaml()) == mechanism
    (load,) = (c for c in mechanism.components if c.section == "loads")
    made = linkages.Mechanism(components=mechanism.components, name=mechanism.name)
    again = linkages.loads(made.to_yaml())  # numbers in SI: their units are gone
    assert again.loads[0].law.places == mechanism.loads[0].law.places
    assert again.loads[0].law.over == mechanism.loads[0].law.over
    assert load.torque.table.at[1].value == pytest.approx(math.pi / 2)


def test_another_file_by_set_and_none_afterwards(law, tmp_path):
    """The values become part of the mechanism: copies and sweeps do without the file."""
    (tmp_path / "other.csv").write_text("0,5\n1,6\n2,5")
    found = law("file: gas.csv, periodic: true", set={"loads[0].torque.table.file": "other.csv"})
    assert (found.values, found.periodic) == ((5, 6, 5), True)
    mechanism = linkages.load(
        tmp_path / "engine.yaml", set={"loads[0].torque.table.periodic": "no"}
    )
    (tmp_path / "gas.csv").unlink()
    again = from_document(pickle.loads(pickle.dumps(mechanism)).document)
    assert again.loads == mechanism.loads
    assert again.loads[0].law.values == (1, 3, 2.5)


def test_a_text_has_no_folder():
    with pytest.raises(InputError, match=r"line 5, column 31, .*no folder to look for this one in"):
        linkages.loads(DEFINITION.replace("TABLE", "file: gas.csv"))


@pytest.mark.parametrize(
    ("table", "csv", "found"),
    [
        ("file: nix.csv", CSV, r"table\.file: no such file: nix\.csv"),
        (
            "file: /dev/zero",
            CSV,
            "/dev/zero is outside of the folder .* --tables-from, or tables_from",
        ),
        ("file: ../../gas.csv", CSV, r"\.\./\.\./gas\.csv is outside of the folder of the definit"),
        ('file: "gas\\0.csv"', CSV, "no such file"),
        ("file: .", CSV, r"no such file: \."),
        ("file: [a]", CSV, "expected the name of a CSV file, found a list"),
        ("file: gas.csv", "", r"gas\.csv is empty"),
        ("file: gas.csv", "t,F\n", r"gas\.csv has one line of names and no numbers"),
        ("file: gas.csv", b"0,1\n1,\xff\n", r"gas\.csv, line 2, column 3: byte 0xff .* CSV file"),
        ("file: gas.csv", "0,1\n" * (MAX_ROWS + 1), f"expected at most {MAX_ROWS}"),
        ("file: gas.csv", "0,1\n1,x\n", r"gas\.csv, line 2: expected a number$"),
        (
            "file: gas.csv",
            "0;1\n1;2,5\n",
            "line 2: expected a number; decimals are written with a po",
        ),
        (
            "file: gas.csv",
            "t;F\n0;1\n1;2,5\n",
            "line 3: expected a number; decimals are written with",
        ),
        ("file: gas.csv", "1" * 131_073, "line 1: a cell is longer than 131072 characters"),
        ("file: gas.csv", "t,F\n0,1,5\n", r"line 2: expected 2 cells as in line 1, found 3"),
        ("file: gas.csv", "0,1\n1,nan\n", "line 2: expected a number$"),
        ("file: gas.csv", "0,1\n1,1e999\n", "line 2: expected a number$"),
        ("file: gas.csv", "0,1\n2,1\n1,1\n", "line 3: expected increasing times$"),
        (
            "file: gas.csv, columns: [time, laod]",
            CSV,
            r"columns\[1\]: gas.csv has no column 'laod'",
        ),
        (
            "file: gas.csv, columns: [0, 2]",
            CSV,
            "has no column '0'; expected a name in its first line, or",
        ),
        ("file: gas.csv, columns: [t, F]", "0,1\n1,2", "no names; expected a number from 1 to 2"),
        ("file: gas.csv, columns: load", CSV, "expected two names or numbers, of times and of"),
        ("file: gas.csv, columns: [t, t]", "t,t\n0,1", "has 2 columns 't'; expected their number"),
        ("file: gas.csv, units: [ms, kN]", CSV, r"values\[0\]: .*kN is a force, not a torque"),
        ("file: gas.csv, units: [ms, kX]", CSV, r"units\[1\]: expected a unit, found 'kX'"),
        ("file: gas.csv, times: [1]", CSV, "'file' and 'times' are both given; expected one"),
        ("file: gas.csv, colums: [1, 2]", CSV, "unknown key 'colums'; did you mean 'columns'"),
    ],
)
def test_what_is_no_table(law, table, csv, found):
    """One message each, at the line of the definition, with the file and its line."""
    with pytest.raises(InputError, match=rf"line 5, column \d+, loads\[0\].*{found}") as caught:
        law(table, csv)
    assert len(caught.value.problems) == 1


def test_a_table_outside_of_the_folder_is_read_where_the_call_says_so(tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "gas.csv").write_text(CSV)
    (inner / "linked.csv").symlink_to(tmp_path / "gas.csv")
    file = inner / "engine.yaml"
    for name in ("../gas.csv", str(tmp_path / "gas.csv"), "linked.csv"):
        file.write_text(DEFINITION.replace("TABLE", f"file: {name}"))
        with pytest.raises(InputError, match="outside of the folder of the definition"):
            linkages.load(file)
        mechanism = linkages.load(file, tables_from=tmp_path)
        assert mechanism.loads[0].law.values == (1, 3, 2.5)
        assert mechanism.with_values({"bars.a.mass": 2}).loads == mechanism.loads
    file.write_text(DEFINITION.replace("TABLE", "file: ../inner/gas.csv"))
    (inner / "gas.csv").write_text(CSV)  # this name does not leave it in the end
    assert linkages.load(file).loads[0].law.values == (1, 3, 2.5)


@pytest.mark.parametrize(
    "columns", ["", ", columns: [a, b]", ", columns: [1, 2]", ", columns: [3, 1]"]
)
@pytest.mark.parametrize(
    "text", ["secret\n", "secret,secret2\n", "1,2\nsecret,secret\n", "2,3\n1,7\n"]
)
def test_messages_do_not_repeat_what_a_file_contains(law, columns, text):
    with pytest.raises(InputError) as caught:
        law(f"file: gas.csv{columns}", text)
    assert "secret" not in str(caught.value)
