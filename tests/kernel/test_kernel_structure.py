"""What is remembered of structures: made once, by one thread, and not without bound."""

import threading

import pytest

import linkages
from linkages.kernel.structure import MOST_STRUCTURES, Remembered, structure_of

CHAIN = "joints: {O: [0, 0]}\nbars:\n"


def test_what_was_not_asked_for_longest_is_forgotten():
    made = []
    kept = Remembered(2)
    for key in "abacab":
        assert kept.get(key, lambda k=key: made.append(k) or k.upper()) == key.upper()
        assert len(kept) <= 2
    assert made == ["a", "b", "c", "b"]


def test_one_thread_makes_what_others_wait_for():
    made, kept = [], Remembered(4)
    entered, go_on = threading.Event(), threading.Event()

    def make():
        made.append(1)
        entered.set()
        assert go_on.wait(60)
        return object()

    found = []
    first = threading.Thread(target=lambda: found.append(kept.get("a", make)))
    others = [threading.Thread(target=lambda: found.append(kept.get("a", make))) for _ in range(3)]
    first.start()
    assert entered.wait(60)
    for thread in others:
        thread.start()
    go_on.set()
    for thread in (first, *others):
        thread.join(60)
    assert len(made) == 1
    assert len(found) == 4
    assert len(set(map(id, found))) == 1


def test_a_failure_is_not_remembered():
    kept = Remembered(2)
    with pytest.raises(ZeroDivisionError):
        kept.get("a", lambda: 1 // 0)
    assert kept.get("a", lambda: 2) == 2


def test_many_structures_do_not_fill_the_memory():
    def pendulum(name):
        return linkages.loads(f"{CHAIN}  {name}: {{joints: [O, A], length: 1, mass: 1}}\n"
                              f"free: {{{name}: {{angle: 1}}}}")  # fmt: skip

    first = structure_of(pendulum("bar"))
    assert structure_of(pendulum("bar")) is first
    for number in range(MOST_STRUCTURES):
        structure_of(pendulum(f"bar{number}"))
    again = structure_of(pendulum("bar"))
    assert again is not first
    assert again.key == first.key
