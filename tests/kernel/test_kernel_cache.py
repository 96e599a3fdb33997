import hashlib
import os
import stat
import subprocess
import sys
import warnings

import pytest
from linkage_models import FOLDER

from linkages.kernel.code.machine import ENVIRONMENT_VARIABLE, MachineCode, Path, cache_folder, kept
from linkages.reading.output_files import is_own

pytestmark = pytest.mark.skipif(os.name == "nt", reason="permissions of POSIX")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache of this test's own."""
    place = tmp_path / "kernels"
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))
    cache_folder.cache_clear()
    yield place
    cache_folder.cache_clear()


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def test_the_folder_is_made_and_private(folder):
    assert cache_folder() == folder
    assert mode(folder) == 0o700


@pytest.mark.usefixtures("folder")
def test_parents_are_made(tmp_path, monkeypatch):
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path / "a" / "b"))
    assert cache_folder() == tmp_path / "a" / "b" / "kernels"


@pytest.mark.usefixtures("folder")
def test_the_named_folder_itself_is_left_as_it_is(tmp_path):
    tmp_path.chmod(0o755)
    cache_folder()
    assert mode(tmp_path) == 0o755


@pytest.mark.parametrize("rights", [0o777, 0o770, 0o1777])
def test_an_open_folder_is_not_used_and_not_repaired(folder, rights):
    """Others may have put code there already: a right seal is no proof."""
    kept("a key", ".o", made(b"code of somebody else")[0])
    cache_folder.cache_clear()
    folder.chmod(rights)
    with pytest.warns(UserWarning, match="others can write to .*kernels.*chmod go-w .*kernels"):
        assert cache_folder() is None
    assert mode(folder) == rights
    assert kept("a key", ".o", made()[0]) == (b"machine code", False)


def test_a_folder_that_others_can_exchange_is_not_used(folder):
    folder.parent.chmod(0o777)
    with pytest.warns(UserWarning, match="others can write to .*; if you trust what is there"):
        assert cache_folder() is None
    folder.parent.chmod(0o1777)  # as /tmp
    cache_folder.cache_clear()
    assert cache_folder() == folder


def test_a_folder_behind_a_link_is_used_under_its_own_name(folder, monkeypatch):
    """A link may be exchanged later: what was checked is used."""
    (folder.parent / "link").symlink_to(folder.parent)
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(folder.parent / "link"))
    assert cache_folder() == folder


@pytest.mark.parametrize("change", ["owner", "rights"])
def test_files_of_others_are_not_loaded(folder, change):
    kept("a key", ".o", made(b"code of somebody else")[0])
    (file,) = folder.glob("*.o")
    if change == "rights":
        file.chmod(0o666)
    elif os.getuid() == 0:
        os.chown(file, 12345, 12345)
    else:
        pytest.skip("only root can give a file away")
    assert kept("a key", ".o", made()[0]) == (b"machine code", False)
    assert kept("a key", ".o", made()[0]) == (b"machine code", True)  # it took its place
    assert is_own(file.stat())


def test_systems_without_owners(folder, monkeypatch):
    """On Windows access-control lists protect the user's profile."""
    monkeypatch.delattr(os, "geteuid")
    folder.mkdir(mode=0o777)
    assert cache_folder() == folder
    assert kept("a key", ".o", made()[0]) == (b"machine code", False)
    assert kept("a key", ".o", made()[0]) == (b"machine code", True)


def test_a_full_disk_costs_time_and_no_more(folder, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    assert cache_folder() == folder
    monkeypatch.setattr(Path, "replace", full)
    assert kept("a key", ".o", made()[0]) == (b"machine code", False)
    assert not [*folder.iterdir()]


@pytest.mark.parametrize("content", [b"", b"no lines", b"f i64\n\nno object file"])
def test_a_sealed_file_that_is_no_machine_code_is_made_anew(folder, content):
    text = "define i64 @f(i64 %x) {\n  ret i64 %x\n}\n"
    MachineCode(text)
    (file,) = folder.glob("*.o")
    before = file.read_bytes()
    file.write_bytes(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
    assert MachineCode(text).function("f")(7) == 7
    assert file.read_bytes() == before


def test_the_users_cache_by_default(folder, tmp_path, monkeypatch):
    monkeypatch.delenv(ENVIRONMENT_VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    cache_folder.cache_clear()
    assert cache_folder().name == "kernels"
    assert tmp_path in cache_folder().parents
    assert not folder.exists()


def made(content=b"machine code"):
    """A maker, and how often it was asked."""
    calls = []

    def make():
        calls.append(content)
        return content

    return make, calls


def test_what_was_made_is_kept_by_its_key(folder):
    make, calls = made()
    assert kept("a key", ".o", make) == (b"machine code", False)
    assert kept("a key", ".o", make) == (b"machine code", True)
    assert len(calls) == 1
    assert kept("another key", ".o", made(b"other")[0]) == (b"other", False)
    assert len([*folder.glob("*.o")]) == 2


def test_no_other_files_are_left(folder):
    kept("a key", ".o", made()[0])
    assert {f.suffix for f in folder.iterdir()} == {".o"}


@pytest.mark.parametrize("content", [b"", b"tampered", b"0" * 64 + b"\nmachine code", b"\xff\n"])
def test_a_changed_file_is_made_anew(folder, content):
    kept("a key", ".o", made()[0])
    (file,) = folder.glob("*.o")
    before = file.read_bytes()
    file.write_bytes(content)
    make, calls = made()
    assert kept("a key", ".o", make) == (b"machine code", False)
    assert len(calls) == 1
    assert file.read_bytes() == before


def test_a_cut_file_is_made_anew(folder):
    kept("a key", ".o", made(bytes(range(256)))[0])
    (file,) = folder.glob("*.o")
    file.write_bytes(file.read_bytes()[:-1])
    assert kept("a key", ".o", made(bytes(range(256)))[0]) == (bytes(range(256)), False)


def test_what_cannot_be_made_is_not_kept(folder):
    def fail():
        raise ZeroDivisionError

    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            kept("a key", ".o", fail)
    assert not [*folder.iterdir()]


def test_a_place_that_is_no_folder(folder):
    folder.write_text("a file")
    with pytest.warns(UserWarning, match="compiled kernels are not kept .*kernels") as caught:
        assert cache_folder() is None
    assert ENVIRONMENT_VARIABLE in str(caught[0].message)
    shown = warnings.formatwarning("", UserWarning, caught[0].filename, caught[0].lineno)
    assert shown == "linkages:0: UserWarning: \n"  # no line of the package
    assert kept("a key", ".o", made()[0]) == (b"machine code", False)  # and warns once
    assert folder.read_text() == "a file"


@pytest.mark.skipif(os.name == "nt" or os.getuid() != 0, reason="only root can give a folder away")
def test_a_folder_of_somebody_else(folder):
    """Whoever owns the folder could make us import what he likes."""
    folder.mkdir()
    os.chown(folder, 12345, 12345)
    with pytest.warns(UserWarning, match="kernels belongs to another user"):
        assert cache_folder() is None
    assert not [*folder.iterdir()]


@pytest.mark.skipif(os.name != "nt" and os.getuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_made(folder):
    folder.parent.chmod(0o500)
    try:
        with pytest.warns(UserWarning, match="compiled kernels are not kept"):
            assert cache_folder() is None
    finally:
        folder.parent.chmod(0o700)


@pytest.mark.usefixtures("folder")
def test_a_folder_that_the_system_refuses(monkeypatch):
    """The same as above, for root as well."""

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.warns(UserWarning, match=r"\(Permission denied\)"):
        assert cache_folder() is None


SCRIPT = """
import logging, sys
import numpy as np
from linkages.components.mechanisms.definition import load
from linkages.kernel.system import System
from linkages.solution.plan import Plan
from linkages.solvers.flow import caller
logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
system = System(load(sys.argv[1]))
flow = Plan.of(system).bind(system)
print(*caller(flow, flow.written)(0.0, system.state))
"""


@pytest.mark.slow
def test_processes_share_an_empty_cache(folder):
    """Four at once find nothing and compile the same; a fifth compiles nothing."""
    command = [sys.executable, "-c", SCRIPT, str(FOLDER / "doublependulum.yaml")]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    started = [subprocess.Popen(command, **pipes) for _ in range(4)]
    results = []
    for process in started:
        output, errors = process.communicate()
        assert process.returncode == 0, errors
        results.append(output)
    assert len(set(results)) == 1
    assert results[0].startswith("0 [")
    assert len([*folder.glob("*.o")]) == 1
    assert not [*folder.glob("*.tmp")]
    last = subprocess.run(command, capture_output=True, text=True, check=True)
    assert last.stdout == results[0]
    assert "was known" in last.stderr


KEYS = """
import sys
from linkages.kernel import dyads
dyads.LEAST_MARGIN *= float(sys.argv[1])
from linkages.kernel.code import machine
def recorded(key, *_, **__):
    print(machine.digest_of(key))
    raise ZeroDivisionError
machine.kept = recorded
from linkages.solvers.loops import step_loop
from linkages.solvers.explicit_methods import dop853_tableau
from linkages.solvers.loops.row_layout import RowLayout
from linkages.solvers.loops.explicit_steps import compiled_step
from linkages.solvers.loops.scalar_stages import Loaded
tableau = dop853_tableau()
layout = RowLayout(
    n=4, blocks=1, first_carried=4, carried=0, counted=0, width=20, rotates=(False,) * 4
)
for use in (
    lambda: compiled_step(tableau, layout),
    lambda: Loaded(step_loop.__name__, "conclude_step").address,
    lambda: Loaded(step_loop.__name__, "begin_motion").address,
):
    try:
        use()
    except ZeroDivisionError:
        pass
"""


def test_a_constant_of_another_folder_changes_the_keys_of_steps_and_loops():
    """Machine code of an earlier release is not used with the limits of this one."""
    one, same, other = (
        subprocess.run(
            [sys.executable, "-c", KEYS, factor], capture_output=True, text=True, check=True
        ).stdout.split()
        for factor in ("1", "1", "2")
    )
    assert one == same
    assert len(one) == 3
    assert not set(one) & set(other)
