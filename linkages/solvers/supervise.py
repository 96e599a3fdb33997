"""Run a compiled loop in a worker thread, so that it can be watched and stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable

from linkages.interrupts import interrupts_kept

POLL = 0.05


def supervise(
    loop: Callable[[], int], stop: Callable[[], None], look: Callable[[], None]
) -> tuple[int, bool]:
    """Run a loop; Ctrl-C stops it after its present step and keeps what was computed.

    Parameters
    ----------
    loop
        Leaves the global interpreter lock to others. It is compiled and loaded already: Python's
        main thread has the larger stack and sees Ctrl-C.
    stop
        Asks it to end.
    look
        Called about 20 times a second, and once at the end.

    Returns
    -------
    What the loop returns, and whether Ctrl-C was pressed, even if the loop had just come to its
    end: who called it may have more to compute, and must hear of it.

    Notes
    -----
    A loop in the main thread could not be interrupted: Python handles signals there, between
    bytecodes, and a compiled loop has none.
    """
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
    interrupted = ended = False
    try:
        with interrupts_kept():
            worker.start()
            ended = done.wait(POLL)
        look()
        while not ended:
            with interrupts_kept():
                ended = done.wait(POLL)
            look()
    except BaseException as failure:
        if worker.ident is None:  # nothing has begun
            raise
        stop()
        interrupted = isinstance(failure, KeyboardInterrupt)
        if not interrupted:
            done.wait()
            raise
    if not ended:
        done.wait()
    if failures:
        raise failures[0]
    return results[0], interrupted
