"""Runs kernels for one state or for several lanes, for the tests of this folder."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.program import Program
from linkages.kernel.code.statements import Routine
from linkages.kernel.code.writer import write_assembly


@dataclass
class Results:
    """What routines wrote, one column per state: arrays of shape (entries, states).

    A status is that of the first routine that had one.
    """

    arrays: dict[str, np.ndarray]
    status: np.ndarray

    def assert_same_bits(self, other: "Results") -> None:
        """All statuses are equal, and all bits of states without one."""
        np.testing.assert_array_equal(self.status, other.status)
        good = self.status == 0
        for name, values in self.arrays.items():
            found, expected = (
                np.ascontiguousarray(a[:, good]) for a in (values, other.arrays[name])
            )
            # nan has many: which one a function gives is its own affair
            np.testing.assert_array_equal(np.isnan(found), np.isnan(expected), name)
            found[np.isnan(found)] = expected[np.isnan(expected)] = 0.0
            np.testing.assert_array_equal(found.view(np.int64), expected.view(np.int64), name)


def run_routines(
    routines: Sequence[Routine],
    given: dict[str, np.ndarray],
    lanes: int,
    code: MachineCode | None = None,
) -> Results:
    """Call routines one after the other for many states, `lanes` of them at once.

    Parameters
    ----------
    routines
        In the order of their calls.
    given
        Array → its entries for all states, shape (entries, states); the time as ``"t"``, shape
        (1, states). Arrays that are not given begin as zeros.
    lanes
        Number of states in a call; 1 is the routine for one state.
    code
        The compiled routines, if they are.
    """
    code = code or MachineCode(write_assembly(routines, lanes))
    sizes = {name: size for routine in routines for name, size in routine.arguments.items()}
    count = next(iter(given.values())).shape[1]
    assert count % lanes == 0
    arrays = {name: np.zeros((max(1, size), count)) for name, size in sizes.items()}
    for name, values in given.items():
        arrays[name][: len(values)] = values
    status = np.zeros(count, dtype=np.int64)
    for routine in routines:
        function = code.function(routine.name)
        for first in range(0, count, lanes):
            columns = slice(first, first + lanes)
            blocks = {name: arrays[name][:, columns].copy() for name in routine.arguments}
            ended = np.full(lanes, -1, dtype=np.int64)
            if lanes == 1:
                values = [
                    block[0, 0] if name == "t" else block.ctypes.data
                    for name, block in blocks.items()
                ]
                ended[0] = function(*values)
            else:
                function(*(block.ctypes.data for block in blocks.values()), ended.ctypes.data)
            for name, block in blocks.items():
                arrays[name][:, columns] = block
            status[columns] = np.where(status[columns], status[columns], ended)
    return Results(arrays, status)


def states_of(of, program: Program, count: int, spread: float = 0.05) -> dict[str, np.ndarray]:
    """Parameters, times and states about that of a system, for `run_routines`."""
    random = np.random.default_rng(1)
    rates = next(routine for routine in program.routines if routine.name == "rates")
    y = np.zeros((max(1, rates.arguments["y"]), count))
    state = of.state[:, None] + spread * random.normal(size=(len(of.state), count))
    y[: len(state)] = state
    p = np.zeros((max(1, sum(program.parameters) + program.held), count))
    p[: program.parameters[0]] = of.parameters[:, None]
    if program.held:
        p[-program.held :] = random.choice([-1.0, 1.0], size=(program.held, count))
    return {"p": p, "t": random.uniform(0, 5, (1, count)), "y": y}
