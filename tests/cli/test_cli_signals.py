"""Real signals to real processes: what there is is kept, and nothing complete is lost.

Nothing here waits for a time: a process says on standard error (`--verbose`) that it has come so
far, and only then it gets its signal.
"""

import os
import signal
import subprocess
import sys

import pytest
import xarray as xr
from shared_definitions import DRIVEN_PENDULUM

pytestmark = [
    pytest.mark.slow_except(),
    pytest.mark.skipif(os.name != "posix", reason="signals of POSIX"),
]

PENDULUM = DRIVEN_PENDULUM + "simulate: {end: 10, samples: 101, rtol: 1e-8}\n"

KEEPS = "from now on a signal keeps what there is"
DAMPING = "dampers[0].damping"

# verb → arguments of a run that is soon over, and of one that takes hours
RUNS = {
    "simulate": ("", "--set simulate.end=1e9 --set simulate.samples=1000001"),
    "map": (
        f"--x {DAMPING}=0.5:0.8:2 --y masses.P=1:2:2 --periods 4",
        f"--x {DAMPING}=0.5:0.8:300 --y masses.P=1:2:300 --periods 4",
    ),
    "bifurcation": (
        f"--vary {DAMPING}=0.5:0.8:2 --periods 2 --skip 0",
        f"--vary {DAMPING}=0.5:0.8:100000 --periods 2 --skip 0",
    ),
    "chaos": ("--quick", "--periods 100000"),
    "poincare": ("--periods 3", "--periods 1000000"),
    "lyapunov": ("--periods 20", "--periods 1000000"),
}
FILES = {
    "simulate": "simulate.nc",
    "map": "map.nc",
    "bifurcation": "bifurcation.nc",
    "chaos": "chaos_exponents.nc",
    "poincare": "poincare.nc",
    "lyapunov": "lyapunov.nc",
}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "pendulum.yaml").write_text(PENDULUM)
    return tmp_path


@pytest.fixture
def complete(cli, folder):  # noqa: ARG001
    """Run a verb to its end, in this process."""

    def run(verb):
        result = cli(verb, "pendulum.yaml", "--no-figures", *RUNS[verb][0].split())
        assert result.code == 0, result.err

    return run


def interrupted(folder, verb, number):
    """Exit code and last lines of a long run that got a signal once it had something to keep."""
    words = ["-m", "linkages", "-v", verb, "pendulum.yaml", "--no-figures", *RUNS[verb][1].split()]
    with subprocess.Popen(
        [sys.executable, *words],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        for line in process.stderr:
            if KEEPS in line:
                break
        process.send_signal(number)
        rest = process.communicate()[1]
    return process.returncode, rest


def state(folder):
    results = folder / "results/pendulum"
    return {path.name: path.read_bytes() for path in results.iterdir() if path.is_file()}


@pytest.mark.parametrize("verb", ["simulate", "map", "bifurcation", "poincare"])
def test_sigterm_keeps_what_there_is_beside_what_is_complete(folder, complete, verb):
    complete(verb)
    before = state(folder)
    code, said = interrupted(folder, verb, signal.SIGTERM)
    assert code == 1
    assert "Traceback" not in said
    assert state(folder) == before
    unfinished = folder / "results/pendulum/unfinished"
    assert str(unfinished.relative_to(folder)) in said
    with xr.open_dataset(unfinished / FILES[verb], engine="h5netcdf") as data:
        assert data.attrs["complete"] == "no"
        assert RUNS[verb][1].split()[1] in data.attrs["command"]
    complete(verb)
    assert not unfinished.exists()
    assert state(folder).keys() == before.keys()


@pytest.mark.parametrize("verb", ["lyapunov", "chaos"])
def test_sigterm_while_exponents_are_computed(folder, verb):
    """There may be too few intervals for a result, or some."""
    code, said = interrupted(folder, verb, signal.SIGTERM)
    assert "Traceback" not in said
    assert "interrupted" in said
    found = {path.name for path in (folder / "results").rglob("*.nc")}
    assert found <= {FILES[verb]}
    assert ("up to there" in said) == bool(found)
    assert code == 1


def test_ctrl_c(folder):
    code, said = interrupted(folder, "simulate", signal.SIGINT)
    assert code == 1
    assert "The integration was interrupted." in said
    unfinished = folder / "results/pendulum/unfinished"
    with xr.open_dataset(unfinished / "simulate.nc", engine="h5netcdf") as data:
        assert 0 < data.sizes["time"] < 1_000_001
        assert "end: 1e9" in data.attrs["definition"]


@pytest.mark.slow_except("*")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_while_the_program_starts(folder, number):
    """In the midst of its imports the process ends, without a traceback and without files."""
    code = f"""
import os, signal, sys
class Finder:
    def find_spec(self, name, *_):
        if name == "numpy":
            os.kill(os.getpid(), {int(number)})
sys.meta_path.insert(0, Finder())
sys.argv = ["linkages", "simulate", "pendulum.yaml"]
from linkages.__main__ import main
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (-number, "", "")
    assert [path.name for path in folder.iterdir()] == ["pendulum.yaml"]


TWICE = """
import signal, sys, threading
from linkages import interrupts
interrupts.end_at_once()
interrupts.keep_from_now_on()
rest = threading.Event()
try:
    print("ready", flush=True)
    rest.wait()
except KeyboardInterrupt:
    print("first", flush=True)
rest.wait()
"""


@pytest.mark.slow_except("*")
@pytest.mark.parametrize("second", [signal.SIGINT, signal.SIGTERM])
def test_second_signal_ends_at_once(second):
    with subprocess.Popen(
        [sys.executable, "-c", TWICE], stdout=subprocess.PIPE, text=True
    ) as process:
        for word, number in (("ready", signal.SIGTERM), ("first", second)):
            assert process.stdout.readline().strip() == word
            process.send_signal(number)
    assert process.returncode == -second


@pytest.mark.slow_except("*")
def test_signals_that_are_ignored_stay_ignored():
    code = TWICE.replace("interrupts.end", "signal.signal(2, signal.SIG_IGN); interrupts.end")
    code += "\n".join(["", "print(signal.getsignal(2) is signal.SIG_IGN)"])
    code = code.replace("rest.wait()", "pass")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["ready", "True"]
