"""Evaluations per second on a graphics processor against those in lanes of a core of the CPU.

    python tests/benchmarks/device.py [--mechanisms ninebar andrews] [--motions 1000 10000]
        [--methods vern9] [--tangents 1] [--end 0.2]

Mechanisms at as many values of one of their numbers, with samples, as sweeps have, or with a
tangent, as maps have. *Launches* is the time of the graphics processor with copies to and fro,
*all* also that of setting motions up in Python and of steps finished on the CPU, by the clock; the
driver has compiled the code before. The lanes are a sample of the same motions, in processor time.
Bits of that sample are compared. It needs an NVIDIA graphics processor.
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import linkages
from linkages.kernel.code.cuda import DeviceError
from linkages.kernel.varying import Varying
from linkages.solution.plan import Plan
from linkages.solvers.device_motions import LOGGER, Accelerator, accelerated
from linkages.solvers.integration import IntegrationRequest, request
from linkages.solvers.lanes import integrate_many
from linkages.solvers.trajectory import Trajectory

CASES = {
    "double-pendulum": ("bars.lower.length", 0.5, 1.5, 20.0),
    "ninebar": ("clearances.r1.size", 1e-4, 4e-4, 0.2),
    "andrews": ("bars.K1.mass", 0.04, 0.05, 0.3),
}
"""Shipped mechanism → what is varied, its least and its greatest value, and the end in seconds."""

METHODS = ("dop853", "vern9")
SAMPLES = 5
COMPARED = 256
"""Motions that are integrated in lanes as well."""

PARTS = ("state", "turns", "acceleration", "final_state", "final_turns")


@dataclass(frozen=True)
class Case:
    """Motions of a mechanism.

    Parameters
    ----------
    mechanism
        A key of `CASES`.
    method, tangents, end
        How they are integrated, and how long.
    """

    mechanism: str
    method: str
    tangents: int
    end: float

    def values(self, count: int) -> NDArray[np.float64]:
        """So many values of what is varied."""
        _, least, greatest, _ = CASES[self.mechanism]
        return np.linspace(least, greatest, count)

    def requests(self, values: NDArray[np.float64]) -> list[IntegrationRequest]:
        """The integrations that are asked for."""
        path = CASES[self.mechanism][0]
        along = Varying(linkages.load(self.mechanism)).along([{path: v} for v in values.tolist()])
        systems = [along.system(index) for index in range(len(values))]
        plan = Plan.of(systems[0], tangents=self.tangents)
        columns = np.eye(len(systems[0].state))[:, : self.tangents]
        times = np.linspace(0.0, self.end, SAMPLES)
        return [
            request(
                plan.bind(one), plan.layout.packed(one.state, 0.0, columns), times,
                method=self.method, rtol=1e-10,
            )
            for one in systems
        ]  # fmt: skip


class Launched(logging.Handler):
    """Sums up the seconds of launches, as integrating says them."""

    seconds = 0.0

    def emit(self, record: logging.LogRecord) -> None:
        """Take them."""
        assert isinstance(record.args, tuple)
        self.seconds += float(record.args[-2])  # type: ignore[arg-type]


def equal_bits(found: Sequence[Trajectory], expected: Sequence[Trajectory]) -> bool:
    """Whether trajectories are equal in all bits."""
    return all(
        np.array_equal(getattr(one, part), getattr(other, part))
        for one, other in zip(found, expected, strict=True)
        for part in PARTS
    )


def measured(card: Accelerator, motions: int, case: Case) -> tuple[float, float, float, bool]:
    """Evaluations per second: in launches, in all, and in lanes; and whether bits are equal."""
    values = case.values(motions)
    places = np.arange(0, motions, max(1, motions // COMPARED))[:COMPARED]
    launched, evaluations, sample = Launched(), 0, []
    with accelerated(card):
        integrate_many(case.requests(values[places]))  # the code is compiled
        LOGGER.addHandler(launched)
        LOGGER.setLevel(logging.INFO)
        begun = time.perf_counter()
        for first in range(0, motions, card.motions):
            part = integrate_many(case.requests(values[first : first + card.motions]))
            evaluations += sum(one.evaluations for one in part)
            sample += [part[k - first] for k in places if first <= k < first + card.motions]
        spent = time.perf_counter() - begun
        LOGGER.removeHandler(launched)
    integrate_many(case.requests(values[places]))
    asked = case.requests(values[places])
    begun = time.process_time()
    expected = integrate_many(asked)
    core = sum(one.evaluations for one in expected) / (time.process_time() - begun)
    return evaluations / launched.seconds, evaluations / spent, core, equal_bits(sample, expected)


def rows(card: Accelerator, cases: Sequence[Case], counts: Sequence[int]) -> Iterator[str]:
    """A table, line by line."""
    yield f"{card.device.name}, {card.device.multiprocessors} multiprocessors"
    yield (
        "mechanism             method  tangents  motions"
        "  evaluations/s: launches, all, a core in lanes  ratios       bits"
    )
    for case in cases:
        for count in counts:
            launches, whole, core, same = measured(card, count, case)
            yield (
                f"{case.mechanism:21} {case.method:7} {case.tangents:8} {count:8} {launches:24.3g} "
                f"{whole:9.3g} {core:12.3g} {launches / core:7.3g} {whole / core:7.3g}"
                f"  {'equal' if same else 'DIFFERENT'}"
            )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mechanisms", nargs="+", choices=CASES, default=["ninebar"])
    parser.add_argument("--methods", nargs="+", default=METHODS)
    parser.add_argument("--tangents", type=int, nargs="+", default=[0, 1])
    parser.add_argument("--motions", type=int, nargs="+", default=[10**3, 10**4, 10**5])
    parser.add_argument("--end", type=float, help="in seconds; default: as suits the mechanism")
    given = parser.parse_args()
    cases = [
        Case(name, method, tangents, given.end or CASES[name][-1])
        for name in given.mechanisms
        for method in given.methods
        for tangents in given.tangents
    ]
    try:
        with Accelerator() as card:
            for row in rows(card, cases, given.motions):
                print(row, flush=True)
    except DeviceError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
