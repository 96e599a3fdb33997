"""Sweeps on an existing Dask cluster: chunks go there, answers come back."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from functools import cache, lru_cache
from importlib.metadata import version
from typing import Any

from linkages.errors import ComputationError, InputError, Problem
from linkages.kernel.code.program import GENERATOR_VERSION
from linkages.sweeps.running import TaskOutcome, attempt

CONNECTING = 10
"""Seconds after which a scheduler that does not answer is given up."""

PER_THREAD = 2
"""Chunks under way for each thread of the workers: one is computed while the next one arrives."""

RETRIES = 3
"""How often a chunk is sent again whose worker was lost."""


class Cluster:
    """The workers of a Dask scheduler.

    A worker builds equations and compiles once for a sweep. What it had under way when it was lost
    is computed by others; a chunk that ended several of them has that as its reason.

    Parameters
    ----------
    address
        Of the scheduler, for example ``"tcp://10.0.0.5:8786"``.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def run(self, task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[TaskOutcome]:
        """Yield outcomes as they come; what is under way is given up when it is closed.

        Raises
        ------
        InputError
            If nobody answers at the address, or Dask is not installed.
        ComputationError
            If a worker has another version of this package, or none.
        """
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
            found: TaskOutcome = future.result()
        except distributed.KilledWorker:
            return TaskOutcome(index, None, "ended every worker that computed it")
        except OtherVersionError as error:
            raise ComputationError(f"{self.address}: {error}", time=None) from None
        except ModuleNotFoundError as error:
            message = f"{self.address}: a worker cannot import what it needs: {error}"
            raise ComputationError(message, time=None) from None
        return found


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
    found: Callable[[Any], Any] = pickle.loads(pickled)
    return found


def _distributed(address: str) -> Any:
    try:
        import distributed
    except ImportError:
        message = 'needs Dask; install it with: pip install "linkages[distributed]"'
        raise _refused(address, message) from None
    return distributed


def _refused(address: str, message: str) -> InputError:
    return InputError("scheduler", [Problem(message=f"{address}: {message}")])
