import importlib
import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from linkage_models import FOLDER

from linkages.kernel.code import cache
from linkages.kernel.code.cache import ENVIRONMENT_VARIABLE, cache_folder, cached_module

TEXT = '"""Generated."""\n\nANSWER = 42\n'
pytestmark = pytest.mark.skipif(os.name == "nt", reason="permissions of POSIX")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache of this test's own."""
    place = tmp_path / "kernels"
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))
    cache_folder.cache_clear()
    known = {name for name in sys.modules if name.startswith("linkages_kernel_")}
    yield place
    cache_folder.cache_clear()
    for name in [n for n in sys.modules if n.startswith("linkages_kernel_") and n not in known]:
        del sys.modules[name]


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def forget(module):
    del sys.modules[module.__name__]
    importlib.invalidate_caches()


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


def test_an_open_folder_is_closed(folder):
    folder.mkdir(mode=0o777)
    folder.chmod(0o777)
    assert cache_folder() == folder
    assert mode(folder) == 0o700


def test_the_users_cache_by_default(folder, tmp_path, monkeypatch):
    monkeypatch.delenv(ENVIRONMENT_VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    cache_folder.cache_clear()
    assert cache_folder().name == "kernels"
    assert tmp_path in cache_folder().parents
    assert not folder.exists()


def test_modules_are_kept_by_their_content(folder):
    module = cached_module(TEXT)
    assert module.ANSWER == 42
    (file,) = folder.glob("*.py")
    assert Path(module.__file__) == file
    assert file.read_text() == TEXT
    assert cached_module(TEXT) is module
    assert cached_module(TEXT.replace("42", "43")).ANSWER == 43
    assert len([*folder.glob("*.py")]) == 2


def test_no_other_files_are_left(folder):
    cached_module(TEXT)
    assert {f.suffix for f in folder.iterdir()} <= {".py", ""}
    assert not [*folder.glob("*.tmp")]


@pytest.mark.usefixtures("folder")
def test_a_right_file_is_left_alone():
    """Numba keeps machine code beside it for as long as its time stamp stays."""
    module = cached_module(TEXT)
    before = os.stat(module.__file__).st_mtime_ns
    forget(module)
    assert cached_module(TEXT).ANSWER == 42
    assert os.stat(module.__file__).st_mtime_ns == before


@pytest.mark.usefixtures("folder")
def test_a_second_writer_does_not_outdate_what_the_first_has_compiled():
    """Two processes find nothing and write the same file, one after the other.

    Older versions of Numba take the time stamp of a file for its content.
    """
    module = cached_module(TEXT)
    first = os.stat(module.__file__).st_mtime_ns
    Path(module.__file__).unlink()
    forget(module)
    module = cached_module(TEXT)
    assert os.stat(module.__file__).st_mtime_ns == first


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("content", ["ANSWER = 'tampered'\n", "", "not Python", TEXT + "\n"])
def test_a_changed_file_is_written_anew(content):
    module = cached_module(TEXT)
    Path(module.__file__).write_text(content)
    forget(module)
    assert cached_module(TEXT).ANSWER == 42
    assert Path(module.__file__).read_text() == TEXT


@pytest.mark.usefixtures("folder")
def test_bytes_that_are_no_text_are_written_anew():
    module = cached_module(TEXT)
    Path(module.__file__).write_bytes(b"\xff\xfe\x00ANSWER")
    forget(module)
    assert cached_module(TEXT).ANSWER == 42


@pytest.mark.usefixtures("folder")
def test_a_faulty_module_does_not_stay():
    before = {name for name in sys.modules if name.startswith("linkages_kernel_")}
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            cached_module("1 / 0\n")
    assert {name for name in sys.modules if name.startswith("linkages_kernel_")} == before


def test_a_place_that_is_no_folder(folder):
    folder.write_text("a file")
    with pytest.warns(UserWarning, match="cannot keep compiled kernels in .*kernels") as caught:
        instead = cache_folder()
    assert ENVIRONMENT_VARIABLE in str(caught[0].message)
    assert instead != folder
    assert mode(instead) == 0o700
    assert cached_module(TEXT).ANSWER == 42  # works all the same, and warns once
    assert folder.read_text() == "a file"


@pytest.mark.skipif(os.name == "nt" or os.getuid() != 0, reason="only root can give a folder away")
def test_a_folder_of_somebody_else(folder):
    """Whoever owns the folder could make us import what he likes."""
    folder.mkdir()
    os.chown(folder, 12345, 12345)
    with pytest.warns(UserWarning, match="it belongs to another user"):
        instead = cache_folder()
    assert instead != folder
    assert not [*folder.iterdir()]


@pytest.mark.skipif(os.name != "nt" and os.getuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_made(folder):
    folder.parent.chmod(0o500)
    try:
        with pytest.warns(UserWarning, match="cannot keep compiled kernels"):
            assert cache_folder() != folder
    finally:
        folder.parent.chmod(0o700)


@pytest.mark.usefixtures("folder")
def test_a_folder_that_the_system_refuses(monkeypatch):
    """The same as above, for root as well."""

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(cache.Path, "mkdir", refuse)
    with pytest.warns(UserWarning, match=r"\(Permission denied\)"):
        assert cache_folder().is_dir()


SCRIPT = """
import ctypes, json, sys
import numpy as np
from linkages.components.mechanisms.definition import load
from linkages.kernel.code.compiled import bind_kernel
from linkages.kernel.code.program import write_program
from linkages.kernel.system import System
of = System(load(sys.argv[1]))
program = write_program(of.model, of.model.free_accelerations)
kernel = bind_kernel(program, of.parameters)
pointer = lambda a: a.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
timed, out = np.zeros(max(1, kernel.timed)), np.zeros(2)
assert kernel.module.clock.ctypes(0.0, pointer(kernel.parameters), pointer(timed)) == 0
status = kernel.module.rates.ctypes(*map(pointer, (of.state, kernel.parameters, timed, out)))
module = kernel.module
hits = sum(f.cache_hits for f in (module.clock, module.rates, module.prepare))
print(json.dumps([status, *out.tolist(), hits]))
"""


@pytest.mark.slow
def test_processes_share_an_empty_cache(folder):
    """Four at once find nothing, write the same file and compile it; a fifth compiles nothing."""
    command = [sys.executable, "-c", SCRIPT, str(FOLDER / "doublependulum.yaml")]
    started = [
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    results = []
    for process in started:
        output, errors = process.communicate()
        assert process.returncode == 0, errors
        results.append(json.loads(output))
    assert len({tuple(result[:3]) for result in results}) == 1
    assert results[0][0] == 0
    assert len([*folder.glob("*.py")]) == 1
    assert not [*folder.glob("*.tmp")]
    last = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert last[:3] == results[0][:3]
    assert last[3] == 3  # clock, rates and prepare from the cache
