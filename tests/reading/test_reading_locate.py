import pytest

from linkages.errors import InputError
from linkages.reading import document as locate
from linkages.reading.document import find, shipped


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package with two shipped mechanisms, and an empty working directory."""
    folder = tmp_path / "package" / "mechanisms"
    folder.mkdir(parents=True)
    for name in ("ninebar", "fourbar"):
        (folder / f"{name}.yaml").write_text("name: x")
    monkeypatch.setattr(locate, "_PACKAGE", folder.parent)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    return folder


def test_shipped_in_alphabetical_order(package):
    assert list(shipped().items()) == [
        ("fourbar", package / "fourbar.yaml"),
        ("ninebar", package / "ninebar.yaml"),
    ]


def test_source_checkout_has_mechanisms_beside_the_package(package, monkeypatch):
    inner = package.parent / "linkages"
    inner.mkdir()
    monkeypatch.setattr(locate, "_PACKAGE", inner)
    assert list(shipped()) == ["fourbar", "ninebar"]


@pytest.mark.parametrize("name", ["fourbar", "fourbar.yaml"])
def test_by_name(package, name):
    assert find(name) == package / "fourbar.yaml"


@pytest.mark.usefixtures("package")
def test_path_comes_first(tmp_path):
    own = tmp_path / "work" / "fourbar.yaml"
    own.write_text("name: own")
    assert find("fourbar.yaml").resolve() == own
    assert find(own) == own


def test_folder_named_like_a_mechanism_does_not_hide_it(package, tmp_path):
    (tmp_path / "work" / "fourbar").mkdir()
    assert find("fourbar") == package / "fourbar.yaml"


@pytest.mark.usefixtures("package")
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("fourbr.yaml", "did you mean 'fourbar'\\? `python -m linkages list`"),
        ("zzz", "shipped; `python -m linkages list` shows"),
        ("mine.yml", "did you mean 'mine.yaml'"),
        (".", "is a directory"),
        ("", "is a directory"),
        ("a\0b", "no such file"),
        ("x" * 5000, "no such file"),
    ],
)
def test_not_found(tmp_path, name, expected):
    (tmp_path / "work" / "mine.yaml").write_text("name: x")
    with pytest.raises(InputError, match=expected):
        find(name)
