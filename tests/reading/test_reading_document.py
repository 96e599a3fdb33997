import os

import pytest

from linkages.errors import InputError
from linkages.reading.document import MAX_COPIES, MAX_NODES, Document, _Builder, parse, read

TEXT = """\
name: Four-bar
joints:
  A: [0, -pi]
  D: [1e-3, on]
bars:
  crank: {joints: [A, B], length: "0.3"}
loads:
  - {bar: crank, torque: 5 N*m}
empty:
"""


def problems(text):
    with pytest.raises(InputError) as caught:
        parse(text, "m.yaml")
    return caught.value.problems


def messages(text):
    return [str(problem) for problem in problems(text)]


def test_scalars_stay_text():
    assert parse(TEXT, "m.yaml").content == {
        "name": "Four-bar",
        "joints": {"A": ["0", "-pi"], "D": ["1e-3", "on"]},
        "bars": {"crank": {"joints": ["A", "B"], "length": "0.3"}},
        "loads": [{"bar": "crank", "torque": "5 N*m"}],
        "empty": None,
    }


@pytest.mark.parametrize(
    ("path", "place"),
    [
        (("name",), (1, 1)),
        (("joints", "D"), (4, 3)),
        (("joints", "D", 1), (4, 13)),
        (("bars", "crank", "length"), (6, 27)),
        (("loads", 0), (8, 5)),
        (("loads", 0, "torque"), (8, 18)),
        (("bars", "crank", "mass"), (6, 3)),
        (("loads", 3), (7, 1)),
        ((), (1, 1)),
    ],
)
def test_positions_count_from_one_and_fall_back_to_what_encloses(path, place):
    assert parse(TEXT, "m.yaml").locate(path) == place


def test_problem_has_dotted_path_and_place():
    problem = parse(TEXT, "m.yaml").problem(("loads", 0, "torque"), "wrong")
    assert str(problem) == "line 8, column 18, loads[0].torque: wrong"


@pytest.mark.parametrize("text", ["\ufeff" + TEXT, TEXT.replace("\n", "\r\n")])
@pytest.mark.parametrize("encode", [False, True], ids=["str", "bytes"])
def test_byte_order_mark_and_crlf(text, encode):
    document = parse(text.encode() if encode else text, "m.yaml")
    plain = parse(TEXT, "m.yaml")
    assert (document.content, document.positions) == (plain.content, plain.positions)


def test_quoted_null_is_text():
    content = parse("a: ~\nb: '~'\nc: null\nd: ''\ne: ", "m.yaml").content
    assert content == {"a": None, "b": "~", "c": None, "d": "", "e": None}


def test_all_problems_of_the_text_at_once():
    text = "a: 1\nb: {c: 1, c: 2}\na: !!python/name:os.system x\n? [1]\n: 2\nd:\n  <<: x\n"
    assert messages(text) == [
        "line 2, column 11, b: duplicate key 'c', first given in line 2",
        "line 3, column 1: duplicate key 'a', first given in line 1",
        "line 3, column 4: tag '!!python/name:os.system' is not allowed; expected a plain value",
        "line 4, column 3: a list or mapping cannot be a key; expected a word followed by ': '",
        "line 7, column 3, d: the merge key '<<' is not supported; write the keys out",
    ]


@pytest.mark.parametrize("tag", ["!foo", "!!float", "!"])
def test_tags_are_refused(tag):
    assert "tag" in messages(f"a: {tag} 1")[0]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "the file is empty"),
        ("# only a comment\n", "the file is empty"),
        ("\n- 1\n", "line 2, column 1: expected a mapping"),
        ("word", "found 'word'"),
        ("a: [1\n", "line 2, column 1: not valid YAML: "),
        ("a:\n\t- b", "line 2, column 1: not valid YAML: found character"),
        ("a: b: c", "line 1, column 5: not valid YAML: mapping values are not allowed"),
        ("a: *nowhere", "undefined alias"),
        ("a: 1\n---\nb: 2", "line 2, column 1: a second document starts here"),
        ("a: &x [*x]", "line 1, column 4, a[0]: this alias contains itself"),
        ("a: &x {b: *x}", "this alias contains itself"),
        (b"a: 1\nb: \xff\n", "line 2, column 4: byte 0xff at byte offset 8 is not text"),
        (b"a: 1\r\nb: x\x00\n", "line 2, column 5: byte 0x00 at byte offset 10 is not text"),
        (b"\xef\xbb\xbfa: \x07", "line 1, column 4: byte 0x07 at byte offset 6 is not text"),
        ("é: \x1b".encode(), "line 1, column 4: byte 0x1b at byte offset 4 is not text"),
        ("a: \ud800", "character U+D800 at byte offset 3 is not text"),
        ("name: x".encode("utf-16"), "byte 0xff at byte offset 0 is not text"),
    ],
)
def test_text_that_is_no_definition(text, expected):
    assert expected in messages(text)[0]


@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_deep_nesting_is_a_problem_not_a_recursion_error(opening):
    assert messages(opening * 10_000)[0].endswith("nested more than 32 deep")


def test_aliases_are_written_out():
    document = parse("a: &x {k: [1, 2]}\nb: *x\n", "m.yaml")
    assert document.content["a"] == document.content["b"]
    assert document.content["a"]["k"] is not document.content["b"]["k"]
    assert document.locate(("b",)) == (2, 1)


def test_alias_bomb_stops_at_the_limit(monkeypatch):
    visits = 0
    original = _Builder.value

    def counted(self, node, path):
        nonlocal visits
        visits += 1
        return original(self, node, path)

    monkeypatch.setattr(_Builder, "value", counted)
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 20)]
    assert "aliases expand to more than 20000 values" in messages("\n".join(lines))[0]
    assert visits < MAX_COPIES + 1000


def test_chain_of_aliases_is_not_followed_without_end():
    lines = ["a0: &a0 [x]", *(f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 5000))]
    assert "aliases nest more than 32 deep" in messages("\n".join(lines))[0]


def test_many_values_stop_at_the_limit():
    text = "a: [" + "1," * (MAX_NODES + 10) + "]"
    assert "more than 400000 keys and values" in messages(text)[0]


def test_read(tmp_path):
    file = tmp_path / "m.yaml"
    file.write_text(TEXT)
    assert read(file) == Document(str(file), parse(TEXT, "").content, parse(TEXT, "").positions)


def test_files_that_cannot_be_read(tmp_path):
    large = tmp_path / "large.yaml"
    with open(large, "wb") as file:
        file.truncate(10_000_001)
    locked = tmp_path / "locked.yaml"
    locked.write_text("a: 1")
    locked.chmod(0)
    cases = {
        tmp_path: "is a directory; expected a YAML file",
        tmp_path / "none.yaml": "no such file",
        large: "larger than 10 MB",
        tmp_path / ("x" * 5000): "cannot be read: File name too long",
        tmp_path / "a\0b": "not a file name",
    }
    if os.geteuid() != 0:
        cases[locked] = "permission denied"
    for path, expected in cases.items():
        with pytest.raises(InputError, match=expected) as caught:
            read(path)
        assert caught.value.source == str(path)
