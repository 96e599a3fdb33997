"""Compare a motion with contact with the hand-written C program beside this, and with SciPy.

    python tests/benchmarks/contact_in_c.py [--json] [REVOLUTIONS]

The slider-crank of tests/data/contact/4-slider-crank-5000rpm.json, DOP853 at a tolerance of 1e-8,
touches and leaves located. All figures are ratios within one run, because machines are noisy: each
pair is timed in turn, several times, and the median is printed. Without a C compiler the program
says so and shows the rest.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from against_c import compile_c
from contact_in_python import Counted
from scipy.integrate._ivp import dop853_coefficients as dop853

import linkages

HERE = Path(__file__).parent
REFERENCE = HERE.parent / "data" / "contact" / "4-slider-crank-5000rpm.json"
REVOLUTIONS, REPEATS, RTOL = 500, 5, 1e-8
PERIOD = 0.012


@dataclass(frozen=True)
class Run:
    """What the C program prints: offset and rate, the slider's velocity, and what it cost."""

    state: tuple[float, ...]
    velocity: float
    evaluations: int
    locating: int
    touches: int
    seconds: float
    events: tuple[tuple[float, str], ...]


def header() -> str:
    """The sums of DOP853's stages (Hairer, Nørsett & Wanner, II.10) as C, without zeros."""

    def total(row: object) -> str:
        parts = [f"{float(v)!r} * k[{j}][i]" for j, v in enumerate(row) if v]  # type: ignore[arg-type]
        return " + ".join(parts)

    lines = []
    for j in range(1, 12):
        lines += [f"#define C_{j} {float(dop853.C[j])!r}", f"#define SUM_{j} {total(dop853.A[j])}"]
    lines.append(f"#define SUM_12 {total(dop853.B)}")
    lines += [f"#define ERROR_3 ({total(dop853.E3)})", f"#define ERROR_5 ({total(dop853.E5)})"]
    return "\n".join(lines) + "\n"


def compiled(folder: Path) -> Path | None:
    """Build the C program; None where there is no compiler."""
    (folder / "dop853.h").write_text(header(), encoding="utf-8")
    return compile_c(folder, "slidercrank_contact")


def run_c(program: Path, end: float, rtol: float, located: bool = True) -> Run:
    """Run the C program and read what it prints."""
    command = [str(program), repr(end), repr(rtol), str(int(located)), "events"]
    *events, last = subprocess.run(
        command, check=True, capture_output=True, text=True
    ).stdout.splitlines()
    numbers = last.split()
    found = [(float(time), kind) for time, kind in (line.split() for line in events)]
    evaluations, locating, touches = map(int, numbers[5:8])
    state = tuple(map(float, numbers[:4]))
    velocity, seconds = float(numbers[4]), float(numbers[8])
    return Run(state, velocity, evaluations, locating, touches, seconds, tuple(found))


def ours(revolutions: int) -> Counted:
    """The same by `simulate`; two samples, so that nearly all is integration."""
    content = json.loads(REFERENCE.read_text(encoding="utf-8"))
    mechanism = linkages.loads(content["definition_in_words_of_a_file"])

    def run(times: int) -> Counted:
        return Counted.of(
            lambda: linkages.simulate(
                mechanism, end=times * PERIOD, samples=2, method="dop853", rtol=RTOL,
                outputs=["clearance_offset"],
            ).motion.cost["evaluations"]
        )  # fmt: skip

    run(1)  # compiled or loaded before anything is timed
    return run(revolutions + 1) - run(1)


def measure(revolutions: int = REVOLUTIONS, repeats: int = REPEATS) -> dict[str, float]:
    """All figures, times in seconds per revolution."""
    from contact_in_python import integrate

    rows: list[dict[str, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        program = compiled(Path(folder))
        for _ in range(repeats):
            found = ours(revolutions)
            row = {"seconds": found.seconds / revolutions}
            row["evaluations"] = found.evaluations / revolutions
            if program is not None:
                located, over = (
                    run_c(program, revolutions * PERIOD, RTOL, by) for by in (True, False)
                )
                row["seconds of C"] = located.seconds / revolutions
                row["evaluations of C"] = located.evaluations / revolutions
                row["seconds / C"] = row["seconds"] / row["seconds of C"]
                row["evaluations / C"] = row["evaluations"] / row["evaluations of C"]
                row["C located / not located"] = located.seconds / over.seconds
                row["evaluations for location in C"] = located.locating / located.evaluations
            rows.append(row)
    scipy = Counted.of(lambda: integrate(PERIOD, RTOL)[1])
    figures = {key: statistics.median(row[key] for row in rows) for key in rows[0]}
    figures["seconds of SciPy"] = scipy.seconds
    figures["evaluations of SciPy"] = scipy.evaluations
    figures["SciPy / seconds"] = scipy.seconds / figures["seconds"]
    return figures


def main(arguments: list[str]) -> None:
    """Measure and print."""
    numbers = [int(argument) for argument in arguments if not argument.startswith("-")]
    figures = measure(*numbers[:1])
    if "--json" in arguments:
        print(json.dumps(figures, indent=2))
        return
    if "seconds / C" not in figures:
        print("no C compiler on this machine: without the hand-written program")
    print(f"{'slider-crank with contact, per revolution':45s} {'value':>12s}")
    for key, value in figures.items():
        print(f"{key:45s} {value:12.6g}")


if __name__ == "__main__":
    main(sys.argv[1:])
