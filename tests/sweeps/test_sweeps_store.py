"""Stores: what is there is whole, goes on after anything, and is never mixed."""

import errno
import json
import os
import signal
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.errors import ComputationError, InputError, Interrupted
from linkages.sweeps import store as stores
from linkages.sweeps.running import Threads
from linkages.sweeps.store import CHUNKS, MANIFEST, RESULT, status

EFFORT = "max(abs(crank.effort))"
ROD = "bars.rod.length"
OVER = {ROD: np.linspace(0.03, 0.15, 60)}

# Free, so that each point takes a while: a point of a millisecond could not be interrupted.
PENDULUM = """\
name: Pendulum on a spring
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
springs: [{bar: arm, stiffness: 2}]
free: {arm: {angle: -1.2, speed: 0}}
simulate: {end: 20, samples: 101, rtol: 1e-8}
"""
SWEEP = """
import linkages, sys
linkages.sweep(
    linkages.loads(open(sys.argv[1]).read()), {"free.arm.angle": "uniform(-1.5, 1.5)"},
    ["max(arm.speed)", "mean(arm.angle)"], draws=24, seed=3, store=sys.argv[2], cores=2,
)
"""


def sweep(folder, over=OVER, measure=EFFORT, **how):
    return linkages.sweep(linkages.load("slider-crank"), over, measure, store=folder, **how)


@pytest.fixture
def small(monkeypatch):
    """Chunks of four points."""
    from linkages.sweeps import point_measures as measured

    monkeypatch.setattr(measured, "TOGETHER", (4, 4))


class Interrupting(Threads):
    """Presses Ctrl-C after some chunks."""

    def __init__(self, after):
        super().__init__(1)
        self.after = after

    def run(self, task, points):
        for number, outcome in enumerate(super().run(task, points)):
            if number == self.after:
                raise KeyboardInterrupt
            yield outcome


@pytest.mark.usefixtures("small")
def test_a_sweep_goes_on_where_it_was_interrupted(tmp_path):
    whole = sweep(tmp_path / "whole")
    with pytest.raises(Interrupted, match="interrupted after 12 of 60") as caught:
        sweep(tmp_path / "parts", executor=Interrupting(3))
    part = caught.value.kept["sweep"]
    assert part.attrs["interrupted"] == 1
    assert part[EFFORT][:12].equals(whole[EFFORT][:12])
    found = status(tmp_path / "parts")
    assert (found["points"], found["done"], found["finished"]) == (60, 12, False)
    seen = []
    again = sweep(tmp_path / "parts", watch=seen.append)
    assert (seen[0].done, seen[0].computed) == (16, 4)
    assert again.identical(whole)
    one, other = (tmp_path / name / RESULT for name in ("whole", "parts"))
    assert one.read_bytes() == other.read_bytes()
    assert status(tmp_path / "parts")["finished"]
    assert status(tmp_path / "parts")["outcomes"] == {"computed": 55, "stopped": 5}


@pytest.mark.usefixtures("small")
def test_what_is_done_is_not_computed_again(tmp_path):
    sweep(tmp_path)

    class Nothing(Threads):
        def run(self, _task, points):
            assert not points
            yield from ()

    assert sweep(tmp_path, executor=Nothing()).identical(sweep(None))


@pytest.mark.slow_except("*0")
@pytest.mark.usefixtures("small")
@pytest.mark.parametrize(
    "spoil",
    [lambda b: b[:-1], lambda b: b[:40] + b"?" + b[41:], lambda b: b[:0], lambda b: b + b"x"],
)
def test_chunks_that_are_not_whole_are_computed_again(tmp_path, spoil):
    whole = sweep(tmp_path)
    result = (tmp_path / RESULT).read_bytes()
    for path in sorted((tmp_path / CHUNKS).iterdir())[::3]:
        path.write_bytes(spoil(path.read_bytes()))
    (tmp_path / CHUNKS / "000000004.part").write_bytes(b"begun")
    assert sweep(tmp_path).identical(whole)
    assert (tmp_path / RESULT).read_bytes() == result
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.parametrize(
    ("change", "entry"),
    [
        ({"over": {ROD: np.linspace(0.03, 0.16, 60)}}, "numbers of points (checksum) is"),
        ({"over": {ROD: np.linspace(0.03, 0.15, 50)}}, "count is '60' there and '50' here"),
        ({"over": {"bars.crank.length": OVER[ROD]}}, "paths is"),
        ({"measure": "min(crank.effort)"}, "measures: min(crank.effort) is 'None' there"),
        ({"end": 0.05}, "options: end is 'None' there and '0.05' here"),
        ({"time_per_point": 5.0}, "seconds per point is 'None' there and '5.0' here"),
    ],
)
def test_another_sweep_is_refused_with_what_differs(tmp_path, change, entry):
    sweep(tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(InputError, match="holds another sweep") as caught:
        sweep(tmp_path, **change)
    assert entry in str(caught.value)
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


def test_another_definition_or_seed_is_refused(tmp_path):
    draws = {"over": {ROD: "normal(0.14, 0.001)"}, "draws": 3}
    sweep(tmp_path, **draws)
    with pytest.raises(InputError, match="seed is '0' there and '1' here"):
        sweep(tmp_path, **draws, seed=1)
    other = linkages.load("slider-crank", set={"bars.crank.mass": 0.9})
    with pytest.raises(InputError, match=r"definition is 'mass: 0.8' there and 'mass: 0.9' here"):
        linkages.sweep(other, draws["over"], EFFORT, draws=3, store=tmp_path)


def test_another_version_is_refused(tmp_path, monkeypatch):
    sweep(tmp_path)
    monkeypatch.setattr(stores, "version", lambda _name: "99")
    with pytest.raises(InputError, match=r"version is 'linkages .*' there and 'linkages 99' here"):
        sweep(tmp_path)


def test_a_second_writer_is_refused(tmp_path):
    class Second(Threads):
        def run(self, task, points):
            with pytest.raises(InputError, match="another process writes into this store"):
                sweep(tmp_path)
            return super().run(task, points)

    sweep(tmp_path, executor=Second(1))


def test_folders_with_other_files_are_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match="found other files"):
        sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
    with pytest.raises(InputError, match="found a file"):
        sweep(tmp_path / "thesis.tex")
    with pytest.raises(InputError, match="expected the store of a sweep"):
        status(tmp_path)


@pytest.mark.usefixtures("small")
def test_a_full_disk_leaves_what_is_there_intact(tmp_path, monkeypatch):
    whole = sweep(None)
    put, room = stores.put, [5]

    def full(path, content):
        if path.parent.name == CHUNKS:
            room[0] -= 1
            if room[0] < 0:
                raise OSError(errno.ENOSPC, "No space left on device")
        put(path, content)

    monkeypatch.setattr(stores, "put", full)
    with pytest.raises(ComputationError, match=r"no space left .* 20 of 60 points are stored"):
        sweep(tmp_path, executor=Threads(1))
    room[0] = 99
    whole_file = []

    def full_at_the_end(path, content):
        if path.name == RESULT:
            whole_file.append(len(content))
            raise OSError(errno.ENOSPC, "No space left on device")
        put(path, content)

    other = tmp_path.with_name(f"{tmp_path.name}-other")
    monkeypatch.setattr(stores, "put", full_at_the_end)
    with pytest.raises(ComputationError, match="60 of 60 points") as caught:
        sweep(other, executor=Threads(1))
    assert f"about {whole_file[0]:.3g} bytes more" in str(caught.value)
    monkeypatch.setattr(stores, "put", put)
    assert status(tmp_path)["done"] == 20
    assert sweep(tmp_path).identical(whole)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no limits of file sizes")
def test_a_limit_of_file_sizes_is_a_full_disk(tmp_path):
    """In a process of its own: the limit cannot be raised again."""
    program = (
        "import resource, linkages, numpy as np, sys\n"
        "m = linkages.load('slider-crank')\n"
        "linkages.simulate(m)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))\n"
        "from linkages.sweeps import point_measures\n"
        "point_measures.TOGETHER = 200, 200\n"
        f"linkages.sweep(m, {{{ROD!r}: np.linspace(0.03, 0.15, 1000)}}, {EFFORT!r},"
        " store=sys.argv[1], cores=1)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert run.returncode == 1
    assert "no space left" in run.stderr
    assert not list(tmp_path.rglob("*.part"))
    found = status(tmp_path)
    assert found["done"] < 1000


@pytest.mark.slow
def test_bifurcations_and_maps_have_stores(tmp_path):
    mechanism = linkages.loads(PENDULUM.replace("free: {", "drives: {}\nfree: {"))
    x, y = {"free.arm.angle": [0.1, 0.2]}, {"free.arm.speed": [0.0, 0.1, 0.2]}
    given = {"indicator": "fli", "periods": 4}
    plain = linkages.chaos_map(mechanism, x, y, **given)
    kept = [linkages.chaos_map(mechanism, x, y, store=tmp_path / "map", **given) for _ in range(2)]
    assert kept[0].identical(plain)
    assert kept[1].identical(plain)
    section = {"section": "arm.speed=0", "periods": 3, "skip": 0, "end": 20.0}
    plain = linkages.bifurcation(mechanism, x, **section)
    folder = tmp_path / "bifurcation"
    kept = [linkages.bifurcation(mechanism, x, store=folder, **section) for _ in range(2)]
    assert kept[0].identical(plain)
    assert kept[1].identical(plain)
    with pytest.raises(InputError, match="holds another sweep"):
        linkages.bifurcation(mechanism, x, store=tmp_path / "map", **section)


CONTINUED = {
    "vary": {"springs[0].stiffness": [f"{k} N m/rad" for k in (2, 2.5, 3, -1e9, 3.5, 4)]},
    "initial": [{"free.arm.angle": -1.0}, {"free.arm.angle": 0.5}],
    "section": "arm.speed=0", "periods": 3, "skip": 2, "end": 20.0,
}  # fmt: skip


def continued(folder, start, **how):
    return linkages.bifurcation(
        linkages.loads(PENDULUM), **CONTINUED, start=start, store=folder, **how
    )


class Third(Threads):
    """Presses Ctrl-C in the midst of the third value, behind its first initial state."""

    calls = 0

    def run(self, task, points):
        type(self).calls += 1
        for outcome in super().run(task, points):
            yield outcome
            if self.calls == 3:
                raise KeyboardInterrupt


@pytest.mark.slow
@pytest.mark.parametrize("start", ["forward", "backward"])
def test_a_continuation_goes_on_where_it_was_interrupted(tmp_path, start, monkeypatch):
    """With the state in which its motions ended, to the last bit; over a value that is refused."""
    plain = continued(None, start)
    assert (plain.outcome.to_numpy() == 0).sum(axis=1).tolist() == [5, 5]
    monkeypatch.setattr(Third, "calls", 0)
    with pytest.raises(Interrupted, match="interrupted after 5 of 12") as caught:
        continued(tmp_path / "parts", start, executor=Third(1))
    assert (caught.value.kept["bifurcation"].outcome != 7).sum() == 5
    assert status(tmp_path / "parts")["done"] == 4
    with pytest.raises(Interrupted):
        continued(tmp_path / "parts", start, executor=Interrupting(1))
    seen = []
    again = continued(tmp_path / "parts", start, watch=seen.append)
    assert (seen[0].done, seen[0].computed) == (6, 2)
    assert again.identical(plain)
    assert continued(tmp_path / "whole", start).identical(plain)
    one, other = (tmp_path / name / RESULT for name in ("whole", "parts"))
    assert one.read_bytes() == other.read_bytes()
    lost = tmp_path / "parts" / CHUNKS / "000000004"
    lost.write_bytes(lost.read_bytes()[:-3])
    assert continued(tmp_path / "parts", start).identical(plain)
    with pytest.raises(InputError, match="holds another sweep"):
        continued(tmp_path / "parts", "backward" if start == "forward" else "forward")


CONTINUATION = """
import linkages, sys
linkages.bifurcation(
    linkages.loads(open(sys.argv[1]).read()),
    {"springs[0].stiffness": [2 + 0.1*k for k in range(24)]},
    section="arm.speed=0", periods=8, skip=4, end=200.0, start="forward", store=sys.argv[2],
)
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_a_killed_continuation_goes_on(tmp_path):
    """Several times, at random moments from the first write on."""
    generator = np.random.default_rng(2)
    folder, done = tmp_path / "killed", 0
    for _ in range(6):
        killed(tmp_path, folder, signal.SIGKILL, done + int(generator.integers(1, 5)), CONTINUATION)
        assert status(folder)["done"] >= done
        done = status(folder)["done"]
    definition = tmp_path / "pendulum.yaml"
    whole = resumed(tmp_path / "whole", definition, CONTINUATION)
    assert resumed(folder, definition, CONTINUATION) == whole


def killed(tmp_path, folder, how, wait, task=SWEEP):
    """A sweep in a process of its own that is ended once some chunks are there."""
    definition = tmp_path / "pendulum.yaml"
    definition.write_text(PENDULUM)
    arguments = [sys.executable, "-c", task, str(definition), str(folder)]
    process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and len(list((folder / CHUNKS).glob("?????????"))) < wait:
        time.sleep(0.001)
    process.send_signal(how)
    process.wait()
    return definition


def resumed(folder, definition, task=SWEEP):
    arguments = [sys.executable, "-c", task, str(definition), str(folder)]
    subprocess.run(arguments, check=True)
    return (folder / RESULT).read_bytes()


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.slow_except("kill")
@pytest.mark.parametrize(
    "how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT], ids=["kill", "terminate", "interrupt"]
)
def test_killed_processes_lose_what_they_compute_and_nothing_else(tmp_path, how):
    definition = killed(tmp_path, tmp_path / "killed", how, 3)
    found = status(tmp_path / "killed")
    assert 3 <= found["done"] <= 24
    whole = resumed(tmp_path / "whole", definition)
    assert resumed(tmp_path / "killed", definition) == whole


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_many_kills_at_random_moments(tmp_path):
    """From the first write on: the set-up, a chunk, the result."""
    generator = np.random.default_rng(1)
    folder, definition = tmp_path / "killed", tmp_path / "pendulum.yaml"
    definition.write_text(PENDULUM)
    done = 0
    for _ in range(40):
        process = subprocess.Popen([sys.executable, "-c", SWEEP, str(definition), str(folder)])
        while process.poll() is None and not (folder / stores.LOCK).exists():
            time.sleep(0.01)
        time.sleep(generator.uniform(0.0, 4.0))
        process.kill()
        process.wait()
        if (folder / MANIFEST).exists():
            found = status(folder)
            assert found["done"] >= done
            done = found["done"]
    whole = resumed(tmp_path / "whole", definition)
    assert resumed(folder, definition) == whole


def test_names_of_files_do_not_depend_on_the_platform(tmp_path):
    sweep(tmp_path)
    names = {str(Path(path).relative_to(tmp_path)) for path in tmp_path.rglob("*")}
    assert names >= {MANIFEST, "points.npy", CHUNKS, RESULT}
    assert np.load(tmp_path / "points.npy")[:, 0].tolist() == OVER[ROD].tolist()


def test_ctrl_c_behind_the_last_point_keeps_all_of_them(tmp_path, monkeypatch):
    """While the dataset is made, of which the first one imports libraries."""
    from linkages.sweeps import sweep as module

    made, plain = module._dataset, sweep(None)
    pressed = []

    def interrupted(*given):
        pressed.append(True)
        if len(pressed) == 1:
            raise KeyboardInterrupt
        return made(*given)

    monkeypatch.setattr(module, "_dataset", interrupted)
    with pytest.raises(Interrupted, match="interrupted after 60 of 60") as caught:
        sweep(tmp_path)
    kept = caught.value.kept["sweep"]
    assert kept.attrs["interrupted"] == 1
    assert kept.equals(plain)
    assert status(tmp_path)["finished"]


def header(content):
    """The header of a chunk, and where its data begin."""
    at = len(stores.MAGIC)
    (size,) = struct.unpack("<Q", content[at : at + 8])
    return json.loads(content[at + 8 : at + 8 + size]), at + 8 + size


def sealed(found, data):
    """A chunk with any header, whole."""
    text = found if isinstance(found, bytes) else json.dumps(found).encode()
    content = stores.MAGIC + struct.pack("<Q", len(text)) + text + data
    return content + struct.pack("<I", zlib.crc32(content))


def with_array(found, name, dtype, shape):
    found["arrays"] = [[n, dtype, shape] if n == name else [n, d, s] for n, d, s in found["arrays"]]
    return found


@pytest.mark.slow_except("*expected 0 to 4")
@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda h: {**h, "span": [4, 8]}, "has points 4 to 8, expected 0 to 4"),
        (lambda h: {**h, "span": [0]}, "has a header that linkages did not write"),
        (lambda h: {**h, "more": 1}, "has a header that linkages did not write"),
        (lambda _: b"{", "has a header that linkages did not write"),
        (lambda _: b"[" * 100_000, "has a header that linkages did not write"),
        (lambda h: with_array(h, "outcome", "O", [4]), "has a header that linkages did not write"),
        (lambda h: with_array(h, "outcome", "|i1", [10**14]), "does not fit its data"),
        (lambda h: with_array(h, "outcome", "|i1", [-4]), "has a header that linkages did not"),
        (lambda h: with_array(h, "outcome", "|i1", [2, 2]), "'outcome' is missing, or of another"),
        (lambda h: with_array(h, "stop_time", "<i8", [4]), "'stop_time' is missing, or of another"),
        (lambda h: {**h, "arrays": [*h["arrays"], *h["arrays"]]}, "does not fit its data"),
    ],
)
@pytest.mark.usefixtures("small")
def test_a_chunk_of_another_store_is_refused_and_named(change, expected, tmp_path):
    whole = sweep(tmp_path)
    first = tmp_path / CHUNKS / "000000000"
    found, at = header(first.read_bytes())
    first.write_bytes(sealed(change(found), first.read_bytes()[at:-4]))
    for read in (status, sweep):
        with pytest.raises(InputError, match=f"000000000: 1 problem\n  .*{expected}"):
            read(tmp_path)
    first.unlink()
    assert sweep(tmp_path).identical(whole)


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize(("at", "code"), [("outcome", 99), ("outcome", -1), ("reason", 27)])
def test_data_of_a_chunk_are_checked(at, code, tmp_path):
    sweep(tmp_path)
    first = tmp_path / CHUNKS / "000000000"
    part = dict(stores.SweepStore(tmp_path, 4, 60).read([(0, 4)], {}))[0, 4]
    part[at] = np.full(4, code, dtype="i1") if at == "outcome" else np.full(4, chr(code))
    first.write_bytes(stores._packed((0, 4), part))
    with pytest.raises(InputError, match=f"'{at}' has .*remove this file"):
        status(tmp_path)


@pytest.mark.parametrize(
    "change",
    [
        {"chunk": 0}, {"count": 10**11, "chunk": 1}, {"count": -1}, {"count": "5"}, {"chunk": 2.5},
        {"count": True}, {"version": 5}, {"question": []}, {"definition": None}, [], "[" * 100_000,
        "", '{"count": 1', b"\xff",
    ],
    ids=lambda change: str(change)[:20],
)  # fmt: skip
def test_a_damaged_manifest_is_one_clear_problem(change, tmp_path):
    (tmp_path / CHUNKS).mkdir()
    good = {"format": 1, "version": "linkages 1", "definition": "", "question": {}}
    good |= {"count": 10, "chunk": 2}
    if isinstance(change, dict):
        change = json.dumps(good | change)
    content = change if isinstance(change, bytes | str) else json.dumps(change)
    (tmp_path / MANIFEST).write_bytes(content.encode() if isinstance(content, str) else content)
    for read in (status, sweep):
        with pytest.raises(InputError, match=rf"{MANIFEST}: 1 problem\n  .*the file is damaged"):
            read(tmp_path)


def test_a_manifest_of_gigabytes_is_not_read(tmp_path):
    with (tmp_path / MANIFEST).open("wb") as file:
        file.truncate(6 * 1024**3)
    with pytest.raises(InputError, match="larger than 32 MiB"):
        status(tmp_path)


def test_an_end_of_a_continuation_is_checked(tmp_path):
    continued(tmp_path, "forward")
    path = sorted((tmp_path / CHUNKS).iterdir())[0]
    found, at = header(path.read_bytes())
    state, other = ("".join(f"{c}\0\0\0" for c in word).encode() for word in ("state", "xxxxx"))
    path.write_bytes(sealed(found, path.read_bytes()[at:-4].replace(state, other)))
    with pytest.raises(InputError, match="'end' is none of a motion; remove this file"):
        continued(tmp_path, "forward")
