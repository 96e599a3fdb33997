"""Make the table of the section "Contact" of docs/benchmark.md.

python docs/figures_contact_speed.py              # from docs/_static/contact-speed.json
python docs/figures_contact_speed.py --measure    # measure first (a minute; machine idle)
"""

from __future__ import annotations

import datetime
import json
import subprocess
import sys

from make.accuracy import ROOT, STATIC, machine, write_table
from make.benchmark import rounded

NUMBERS = STATIC / "contact-speed.json"
BENCHMARK = ROOT / "tests" / "benchmarks" / "contact_in_c.py"


def measure() -> None:
    """Run the benchmark and keep its numbers with the machine and the date."""
    command = [sys.executable, str(BENCHMARK), "--json"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    content = {"machine": machine(), "date": f"{datetime.date.today():%Y-%m-%d}"}
    content |= json.loads(output)
    text = json.dumps(rounded(content), indent=1, ensure_ascii=False)
    NUMBERS.write_text(text + "\n", encoding="utf-8")


def table(content: dict) -> str:
    """Times and evaluations of a revolution, with ratios to the hand-written program."""
    rows = (
        ("written by hand in C", content["seconds of C"], content["evaluations of C"]),
        ("`simulate`", content["seconds"], content["evaluations"]),
        (
            "SciPy, equations in Python",
            content["seconds of SciPy"],
            content["evaluations of SciPy"],
        ),
    )
    lines = ["| program | time | ratio | evaluations |", "|---|--:|--:|--:|"]
    for name, seconds, evaluations in rows:
        ratio = seconds / content["seconds of C"]
        lines.append(f"| {name} | {1e3 * seconds:.3g} ms | {ratio:.3g} | {evaluations:.0f} |")
    note = f"Measured on {content['date']}: {content['machine']}."
    return "\n".join([*lines, "", note, ""])


def main() -> None:
    """Write the table."""
    if "--measure" in sys.argv:
        measure()
    write_table("contact-speed", table(json.loads(NUMBERS.read_text(encoding="utf-8"))))


if __name__ == "__main__":
    main()
