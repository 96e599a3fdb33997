"""Evaluations per second on a graphics processor against those in lanes of a core of the CPU.

    python tests/benchmarks/device.py [--motions 10000 100000 1000000] [--end 0.02]

The nine-bar at as many sizes of its clearance, with samples, as sweeps have, or with a tangent,
as maps have. *Launches* is the time of the graphics processor with copies to and fro, *all*
also that of setting motions up in Python, by the clock. The lanes are a sample of the same motions,
in processor time. Bits of that sample are compared. It needs an NVIDIA graphics processor.
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np

import linkages
from linkages.kernel.code.cuda import DeviceError
from linkages.kernel.varying import Varying
from linkages.solution.moving.plan import Plan
from linkages.solvers.accelerated import LOGGER, Accelerator, accelerated
from linkages.solvers.integration import IntegrationRequest, request
from linkages.solvers.lanes import integrate_many
from linkages.solvers.trajectory import Trajectory

METHODS = ("dop853", "vern9")
SAMPLES = 5
COMPARED = 256
"""Motions that are integrated in lanes as well."""

PARTS = ("state", "turns", "acceleration", "final_state", "final_turns")


def requests(
    sizes: Sequence[float], tangents: int, method: str, end: float
) -> list[IntegrationRequest]:
    """The integrations that are asked for."""
    along = Varying(linkages.load("ninebar")).along([{"clearances.r1.size": s} for s in sizes])
    systems = [along.system(index) for index in range(len(sizes))]
    plan = Plan.of(systems[0], tangents=tangents)
    columns = np.eye(2 * len(systems[0].topology.free))[:, :tangents]
    times = np.linspace(0.0, end, SAMPLES)
    return [
        request(
            plan.bind(one), plan.layout.packed(one.state, 0.0, columns), times, method=method,
            rtol=1e-10,
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


def measured(
    card: Accelerator, motions: int, made: Callable[[Sequence[float]], list[IntegrationRequest]]
) -> tuple[float, float, float, bool]:
    """Evaluations per second: in launches, in all, and in lanes; and whether bits are equal."""
    sizes = np.linspace(1e-4, 4e-4, motions)
    chosen = sizes[:: max(1, motions // COMPARED)][:COMPARED]
    launched = Launched()
    LOGGER.addHandler(launched)
    LOGGER.setLevel(logging.INFO)
    evaluations, begun = 0, time.perf_counter()
    with accelerated(card):
        for first in range(0, motions, card.motions):
            part = integrate_many(made(sizes[first : first + card.motions]))
            evaluations += sum(one.evaluations for one in part)
        spent = time.perf_counter() - begun
        sample = integrate_many(made(chosen))
    LOGGER.removeHandler(launched)
    asked = made(chosen)
    begin = time.process_time()
    expected = integrate_many(asked)
    core = sum(one.evaluations for one in expected) / (time.process_time() - begin)
    share = launched.seconds * evaluations / (evaluations + sum(o.evaluations for o in sample))
    return evaluations / share, evaluations / spent, core, equal_bits(sample, expected)


def rows(card: Accelerator, counts: Sequence[int], end: float) -> Iterator[str]:
    """A table, line by line."""
    yield f"{card.device.name}, {card.device.multiprocessors} multiprocessors"
    yield "method  tangents  motions  evaluations/s: launches, all, a core in lanes  ratio  bits"
    for method in METHODS:
        for tangents in (0, 1):

            def made(
                sizes: Sequence[float], method: str = method, tangents: int = tangents
            ) -> list[IntegrationRequest]:
                return requests(sizes, tangents, method, end)

            for count in counts:
                launches, whole, core, same = measured(card, count, made)
                yield (
                    f"{method:7} {tangents:8} {count:8} {launches:24.3g} {whole:9.3g} {core:12.3g}"
                    f" {launches / core:8.1f}  {'equal' if same else 'DIFFERENT'}"
                )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--motions", type=int, nargs="+", default=[10**4, 10**5, 10**6])
    parser.add_argument("--end", type=float, default=0.02)
    given = parser.parse_args()
    try:
        with Accelerator() as card:
            for row in rows(card, given.motions, given.end):
                print(row, flush=True)
    except DeviceError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
