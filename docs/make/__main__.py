"""Make figures and tables of the pages.

    python docs/make --list              # all outputs: script, seconds, pages
    python docs/make contact-press.svg   # an output
    python docs/make chaos wear.md       # all outputs of a script or of a page
    python docs/make 'paper-*' -j 2      # those that match, two at once
    python docs/make '*'                 # everything: hours
    python docs/make chains.json chains  # measure first (leave the machine idle), then draw

Measured numbers (names that end in .json) are measured only if they are named. Outputs are
committed; docs/figures.md lists them with the processor time that each took, which this program
measures and writes there.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import groupby
from multiprocessing import get_context
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parents[1])

from make.registry import MAKERS, discovered, known, listed, rows, selected, write_table  # noqa: E402


def made(index: int) -> float:
    """Make the outputs of the maker with this number; returns seconds."""
    return MAKERS[index].make()


def main() -> None:
    """Make what is named, and keep the seconds that it took."""
    how = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("python docs/make", description=__doc__, formatter_class=how)
    parser.add_argument("names", nargs="*", help="outputs, scripts or pages, or patterns of these")
    parser.add_argument("--list", action="store_true", help="print the table, of names if given")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="processes")
    given = parser.parse_args()
    makers = discovered()
    try:
        chosen = selected(given.names, makers)
    except ValueError as error:
        parser.error(str(error))
    if given.list or not chosen:
        print(rows(chosen or makers, known()), end="")
        return
    failed = 0
    with ProcessPoolExecutor(given.jobs, get_context("fork")) as pool:
        for _, stage in groupby(chosen, key=lambda maker: maker.stage):
            running = {pool.submit(made, MAKERS.index(maker)): listed(maker) for maker in stage}
            for done in as_completed(running):
                outputs, error = running[done], done.exception()
                if error is not None:
                    print(f"{outputs}: {type(error).__name__}: {error}", flush=True)
                    failed += 1
                    continue
                seconds = f"{float(f'{done.result():.2g}'):g}"
                print(f"{outputs}: {seconds} s", flush=True)
                write_table("figures", rows(makers, {**known(), outputs: seconds}))
    if failed:
        sys.exit(f"{failed} of {len(chosen)} failed")


if __name__ == "__main__":
    main()
