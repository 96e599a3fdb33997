"""Ctrl-C at times of our choosing."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_kept() -> Iterator[Callable[[], None]]:
    """Keep Ctrl-C until it is asked for; yields the function that asks, and raises if it was hit.

    While a library draws, an interrupt may surface as an error of that library (matplotlib's
    compiled parts call it an invalid argument), or not at all. Handlers that somebody else has
    installed stay as they are, and so do threads other than the main one, which get no signals.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield lambda: None
        return
    hit = threading.Event()

    def ask() -> None:
        if hit.is_set():
            hit.clear()
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, lambda *_: hit.set())
    try:
        yield ask
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    ask()
