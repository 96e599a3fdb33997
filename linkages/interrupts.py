"""Ctrl-C, and the signals with which systems end programs.

On the command line they end the process at once as long as there is nothing to keep. From then on
the first of them becomes a KeyboardInterrupt, after which what there is is written, and the second
one ends the process. In Python, Ctrl-C is left as it is.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

LOGGER = logging.getLogger(__name__)

NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
"""Ctrl-C; what batch systems, containers and `timeout` send; a terminal that is closed."""

CODE = 128
"""Shells report this plus the number of the signal that ended a program."""

_watched: list[int] = []
_received: list[int] = []


def end_at_once() -> None:
    """Let all signals end the process, without a word and wherever it is; for whole programs only.

    Signals that the process was told to ignore (`nohup`, a job in the background) stay ignored.
    """
    result = [getattr(signal, name) for name in NAMES if hasattr(signal, name)]
    _watched[:] = [number for number in result if signal.getsignal(number) is not signal.SIG_IGN]
    for number in _watched:
        signal.signal(number, signal.SIG_DFL)


def keep_from_now_on() -> None:
    """There is something to keep: the next signal becomes a KeyboardInterrupt.

    Does nothing but for programs that called `end_at_once`. After a signal it raises, for a
    KeyboardInterrupt may get lost in a callback of a library.
    """
    if _received:
        raise KeyboardInterrupt
    if threading.current_thread() is not threading.main_thread():
        return
    resting = [number for number in _watched if signal.getsignal(number) is signal.SIG_DFL]
    for number in resting:
        signal.signal(number, _interrupt)
    if resting:
        LOGGER.info("from now on a signal keeps what there is")


def received() -> bool:
    """Whether a signal has come."""
    return bool(_received)


def exit_code() -> int:
    """What to exit with after an interrupt: 130 after Ctrl-C, 143 after SIGTERM."""
    return CODE + (_received[0] if _received else signal.SIGINT)


def _interrupt(number: int, _frame: Any) -> None:
    for other in _watched:
        signal.signal(other, signal.SIG_DFL)
    _received.append(number)
    if sys.stderr.isatty():
        os.write(sys.stderr.fileno(), b"\x1b[?25h")  # a progress bar has hidden the cursor
    raise KeyboardInterrupt


@contextmanager
def interrupts_kept() -> Iterator[Callable[[], None]]:
    """Keep signals until they are asked for; yields the function that asks, and raises if one came.

    While a library draws, an interrupt may surface as an error of that library (matplotlib's
    compiled parts call it an invalid argument), or not at all; while the main thread waits for
    others, it may leave a lock of the standard library broken. Handlers that somebody else has
    installed stay as they are, and so do threads other than the main one, which get no signals.
    """
    ours = (signal.default_int_handler, _interrupt)
    present = {n: signal.getsignal(n) for n in {signal.SIGINT, *_watched}}
    kept = {n: handler for n, handler in present.items() if handler in ours}
    if threading.current_thread() is not threading.main_thread() or not kept:
        yield lambda: None
        return
    hit: list[int] = []

    def hold(number: int, _frame: Any) -> None:
        if hit:  # the second one is meant: it ends the process, or Python hears it at once
            end = signal.SIG_DFL if kept[number] is _interrupt else kept[number]
            signal.signal(number, end)
            signal.raise_signal(number)
        hit.append(number)

    def put_back() -> None:
        for number, handler in kept.items():
            signal.signal(number, handler)

    def ask() -> None:
        if hit:
            put_back()
            signal.raise_signal(hit.pop())

    for number in kept:
        signal.signal(number, hold)
    try:
        yield ask
    finally:
        if not received():
            put_back()
    ask()
