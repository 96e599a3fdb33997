"""Where sweeps run: Dask clusters and graphics processors."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache, lru_cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Problem
from linkages.kernel.code.program import GENERATOR_VERSION
from linkages.options.option import OptionError
from linkages.solvers.device_motions import Accelerator, accelerated
from linkages.sweeps.engine import Computed, Question, Watch, computed, dataset_of
from linkages.sweeps.running import Executor, TaskOutcome, Threads, attempt, available_cores
from linkages.sweeps.store import SweepStore, stored

if TYPE_CHECKING:
    import xarray as xr

CONNECTING = 10
"""Seconds after which a scheduler that does not answer is given up."""

PER_THREAD = 2
"""Chunks under way for each thread of the workers: one is computed while the next one arrives."""

RETRIES = 3
"""How often a chunk is sent again whose worker was lost."""


class Cluster:
    """The workers of a Dask scheduler, such as ``"tcp://10.0.0.5:8786"``.

    A worker builds equations and compiles once for a sweep. Chunks of a lost worker are computed by
    others; a chunk that ended several of them fails with that reason.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def run(self, task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[TaskOutcome]:
        """Yield outcomes as they come; what is under way is given up when it is closed."""
        if not points:
            return
        distributed = _distributed(self.address)
        client = self._connected(distributed)
        waiting = iter(enumerate(points))
        asked = (here(), pickle.dumps(task))
        running = distributed.as_completed(loop=client.loop)
        indices: dict[Any, int] = {}

        def fill() -> None:
            threads = sum(client.nthreads().values())
            while len(indices) < max(1, PER_THREAD * threads):
                following = next(waiting, None)
                if following is None:
                    return
                future = client.submit(_attempt, *asked, *following, pure=False, retries=RETRIES)
                indices[future] = following[0]
                running.add(future)

        try:
            fill()
            for future in running:
                yield self._outcome(distributed, future, indices.pop(future))
                fill()
        finally:
            client.cancel(list(indices), force=True)
            client.close()

    def _connected(self, distributed: Any) -> Any:
        try:
            return distributed.Client(self.address, timeout=CONNECTING, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise _refused(self.address, f"no Dask scheduler answers there: {error}") from None

    def _outcome(self, distributed: Any, future: Any, index: int) -> TaskOutcome:
        try:
            result: TaskOutcome = future.result()
        except distributed.KilledWorker:
            return TaskOutcome(index, None, "ended every worker that computed it")
        except OtherVersionError as error:
            raise ComputationError(f"{self.address}: {error}", time=None) from None
        except ModuleNotFoundError as error:
            message = f"{self.address}: a worker cannot import what it needs: {error}"
            raise ComputationError(message, time=None) from None
        return result


class OtherVersionError(Exception):
    """A worker would compute something else."""


@cache
def here() -> str:
    """The versions that results depend on, in words."""
    own = f"linkages {version('linkages')} (kernels {GENERATOR_VERSION})"
    return ", ".join([own, *(f"{name} {version(name)}" for name in ("numpy", "llvmlite"))])


def _attempt(versions: str, task: bytes, index: int, point: Any) -> TaskOutcome:
    """Compute a chunk on a worker."""
    if versions != here():
        raise OtherVersionError(f"a worker has {here()}; expected {versions}, as here")
    return attempt(_task(task), index, point)


@lru_cache(maxsize=4)
def _task(pickled: bytes) -> Callable[[Any], Any]:
    """What is to be done, with the equations that it has made before."""
    result: Callable[[Any], Any] = pickle.loads(pickled)
    return result


def _distributed(address: str) -> Any:
    try:
        import distributed
    except ImportError:
        message = 'needs Dask; install it with: pip install "linkages[distributed]"'
        raise _refused(address, message) from None
    return distributed


def _refused(address: str, message: str) -> InputError:
    return InputError("scheduler", [Problem(message=f"{address}: {message}")])


CPU, CUDA = "cpu", "cuda"

AT_A_TIME = 2
"""Chunks: one is prepared while the other is on the graphics processor."""

MEMORY = 1 << 32
"""Bytes of this machine's memory that the points of a chunk may take, about."""


class OnDevice(Threads):
    """A machine with a graphics processor, which integrates `motions` points together."""

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
    """Where the points of a question are computed."""
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


def swept(
    question: Question,
    mechanism: Mechanism,
    name: str,
    what: str,
    made: Callable[[Computed], xr.Dataset],
    *,
    device: str = CPU,
    executor: Executor | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
    chunk: int | None = None,
    answers: Callable[[Executor | None, SweepStore | None], Computed] | None = None,
) -> xr.Dataset:
    """The dataset of a question of a mechanism, on a device or an executor, kept in a store.

    `name`, `what`: of the dataset, and what its points are called; `made`: makes it.
    `chunk`: points of a chunk of the store, as `stored` has it.
    `answers`: how points are computed, if not each by itself.
    Raises Interrupted as `dataset_of` does.
    """
    with (
        placed(question, device, executor) as where,
        stored(store, mechanism, question, chunk) as place,
    ):
        if answers is None:
            found = computed(question, executor=where, store=place, watch=watch)
        else:
            found = answers(where, place)
        return dataset_of(found, name, what, place, partial(made, found))
