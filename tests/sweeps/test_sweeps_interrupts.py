"""Ctrl-C at the worst of times: while the library waits, in the middle of one of its locks."""

import signal
import threading
import time

import pytest

from linkages.solvers.integration import supervise
from linkages.sweeps.running import Threads


@pytest.fixture(autouse=True)
def interrupted(monkeypatch):
    """The first wait of this thread is interrupted where its lock has just been released."""
    release, sent = threading.Condition._release_save, []

    def released(self):
        state = release(self)
        if threading.current_thread() is threading.main_thread() and not sent:
            sent.append(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
        return state

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    monkeypatch.setattr(threading.Condition, "_release_save", released)
    yield sent
    signal.signal(signal.SIGINT, before)


def test_a_loop_is_stopped_and_keeps_what_it_has(interrupted):
    stopped = threading.Event()

    def loop():
        while not stopped.is_set():
            time.sleep(0.001)
        return 7

    assert supervise(loop, stopped.set, lambda: None) == (7, True)
    assert interrupted


def test_a_sweep_hears_of_it(interrupted):
    def slow(point):
        time.sleep(0.05)
        return point

    found = []
    with pytest.raises(KeyboardInterrupt):
        found.extend(Threads(2).run(slow, range(1000)))
    assert interrupted
    assert len(found) < 1000


def test_a_thread_that_cannot_begin_is_not_waited_for(monkeypatch):
    def refused(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refused)
    with pytest.raises(RuntimeError, match="can't start"):
        supervise(lambda: 0, lambda: None, lambda: None)
