"""Run a compiled loop in a worker thread, so that it can be watched and stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable

from linkages.solvers.job import Job
from linkages.solvers.methods.method import Method
from linkages.solvers.outcome import Outcome

POLL = 0.05


def supervise(method: Method, job: Job, watch: Callable[[float], None] | None) -> Outcome:
    """Run a job; Ctrl-C stops it after its present step and keeps what was computed.

    Parameters
    ----------
    watch
        Called about 20 times a second, and once at the end, with the fraction of simulated time
        that is done.

    Returns
    -------
    Outcome
        Interrupted after Ctrl-C, even if the job had just come to its end: who called it may have
        more to compute, and must hear of it.

    Notes
    -----
    A loop in the main thread could not be interrupted: Python handles signals there, between
    bytecodes, and a compiled loop has none.
    """
    # Compiled and loaded here: Python's main thread has the larger stack and sees Ctrl-C.
    loop = method.prepare(job)
    results: list[int] = []
    failures: list[BaseException] = []
    # Not Thread.join: interrupted in the middle, it may take a running thread for ended.
    done = threading.Event()

    def work() -> None:
        try:
            results.append(loop())
        except BaseException as failure:  # handed over to the calling thread
            failures.append(failure)
        finally:
            done.set()

    worker = threading.Thread(target=work, name="linkages-solver", daemon=True)
    worker.start()
    interrupted = ended = False
    try:
        while not ended:
            ended = done.wait(POLL)
            if watch is not None:
                watch(job.fraction)
    except KeyboardInterrupt:
        interrupted = True
        job.stop()
    except BaseException:
        job.stop()
        done.wait()
        raise
    done.wait()
    if failures:
        raise failures[0]
    return Outcome.INTERRUPTED if interrupted else Outcome(results[0])
