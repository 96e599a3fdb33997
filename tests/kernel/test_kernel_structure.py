"""What is remembered of structures: made once, by one thread, and not without bound."""

import threading

import pytest

import linkages
from linkages.errors import InputError
from linkages.kernel.code.program import write_program
from linkages.kernel.inputs import structure_key
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.model import Model
from linkages.kernel.system import MOST_STRUCTURES, structure_of
from linkages.topology.topology import build_topology

LOADED = """
gravity: [0.3, -9.81]
joints: {O: [0.1, 0.2], C: [1, 0.3], D: [0.4, 0.7]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1.5}
  plate: {points: {A: [0, 0], B: [0.9, 0.1], E: [0.4, 0.5]}, mass: 1.2, center: [0.4, 0.2],
    inertia: 0.1}
  rocker: {joints: [C, B], length: 0.7, mass: 1.1, center: 0.3}
  wheel: {joints: [C, W], length: 0.2, mass: 0.2, inertia: 0.01}
  tail: {joints: [E, F], length: 0.2, mass: 0.3}
sliders: {block: {joint: F, through: D, angle: 25 deg, mass: 0.7}}
masses: {A: 0.4}
gears: [{bars: [rocker, wheel], ratio: -2, angle: 0.2}]
free: {crank: {angle: 1.1, speed: 1.3}}
springs:
  - {between: [O, E], stiffness: 30, length: 0.2, damping: 0.1}
  - {bar: wheel, stiffness: 2, angle: 0.7, damping: 0.3}
dampers: [{joint: B, damping: 0.2}, {slider: block, damping: 0.6}]
loads:
  - {bar: crank, torque: {harmonic: {amplitude: 2, frequency: 3, phase: 0.4, mean: 0.6}}}
  - {joint: E, force: [{rise: cycloidal, from: 0.2, to: 1.4, begin: 0.3, duration: 0.8}, 1.7]}
  - {slider: block, force: {table: {times: [0, 0.4, 1], values: [0.3, 1.2, 0.4]}}}
"""
"""Something of every kind, with no number that is special."""

SPECIAL = (0.0, 1.0, 1.5707963267948966)

CHAIN = "joints: {O: [0, 0]}\nbars:\n"


def test_what_was_not_asked_for_longest_is_forgotten():
    made = []
    kept = LRUCache(2)
    for key in "abacab":
        assert kept.get(key, lambda k=key: made.append(k) or k.upper()) == key.upper()
        assert len(kept) <= 2
    assert made == ["a", "b", "c", "b"]


def test_one_thread_makes_what_others_wait_for():
    made, kept = [], LRUCache(4)
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
    kept = LRUCache(2)
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


def printed(mechanism):
    """The kernel that a mechanism of its own would have."""
    model = Model(build_topology(mechanism))
    return write_program(model, model.integrated_accelerations(model.changes)).text


def places(node, path=""):
    """Dotted paths of all numbers in a definition."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield from places(value, f"{path}.{key}" if path else str(key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from places(value, f"{path}[{index}]")
    elif str(node)[0] in "-0123456789":
        yield path


@pytest.mark.slow
def test_equal_keys_are_equal_kernels():
    """Whatever number takes a special value: no kernel is bound to numbers that it is not of."""
    mechanism = linkages.loads(LOADED)
    key, text = structure_key(mechanism.terms), printed(mechanism)
    tried, structural = 0, set()
    for path in places(mechanism.definition.content):
        for value in SPECIAL:
            try:
                other = mechanism.with_values({path: value})
            except InputError:
                continue
            same = structure_key(other.terms) == key
            assert not same or printed(other) == text, (path, value)
            tried += 1
            structural |= {path} - ({path} if same else set())
    assert tried > 80
    assert {"gravity[0]", "bars.crank.mass", "gears[0].ratio", "sliders.block.angle"} <= structural
    assert not structural & {"bars.crank.length", "bars.rocker.length", "free.crank.angle"}
