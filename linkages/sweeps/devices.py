"""Graphics processors as places where the motions of a sweep are integrated."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from linkages.options.option import OptionError
from linkages.solvers.accelerated import Accelerator, accelerated
from linkages.sweeps.answers import Question
from linkages.sweeps.cores import available_cores
from linkages.sweeps.running import Executor, TaskOutcome, Threads

CPU, CUDA = "cpu", "cuda"

AT_A_TIME = 2
"""Chunks: one is prepared while the other is on the graphics processor."""

MEMORY = 1 << 32
"""Bytes of this machine's memory that the points of a chunk may take, about."""


class OnDevice(Threads):
    """A machine with a graphics processor: motions that go side by side are integrated there.

    Parameters
    ----------
    accelerator
        What integrates them.
    motions
        How many points are computed together.
    """

    def __init__(self, accelerator: Accelerator, motions: int) -> None:
        super().__init__(min(AT_A_TIME, available_cores()))
        self.accelerator, self.motions = accelerator, motions

    def run(self, task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[TaskOutcome]:
        """Yield outcomes as they come; those under way are finished when it is closed."""
        return super().run(partial(_beside, self.accelerator, task), points)


def _beside(accelerator: Accelerator, task: Callable[[Any], Any], point: Any) -> Any:
    with accelerated(accelerator):
        return task(point)


@contextmanager
def placed(question: Question, device: str, executor: Executor | None) -> Iterator[Executor | None]:
    """Where the points of a question are computed.

    Parameters
    ----------
    question
        What is asked.
    device
        ``"cpu"``, or ``"cuda"`` for the first graphics processor of this machine.
    executor
        Where else; with ``"cuda"`` the threads that finish what is left to the CPU.

    Raises
    ------
    OptionError
        If the device is unknown, or does not answer such questions.
    DeviceError
        If there is none.
    """
    if device == CPU:
        yield executor
        return
    if device != CUDA:
        raise OptionError("device", f"found {device!r}; expected '{CPU}' or '{CUDA}'")
    if not (executor is None or isinstance(executor, Threads)):
        raise OptionError(
            "device", f"'{CUDA}' is of this machine; expected no executor or scheduler beside it"
        )
    if question.cpu_only:
        raise OptionError(
            "device", f"{question.cpu_only} is computed on the CPU only; expected '{CPU}'"
        )
    helpers = available_cores() if executor is None else executor.workers
    with Accelerator(helpers=helpers) as accelerator:
        motions = min(accelerator.motions, MEMORY // question.room)
        yield OnDevice(accelerator, motions)
