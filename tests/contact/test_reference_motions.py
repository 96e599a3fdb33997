"""Motions with contact against reference results: states, forces, slip, what must not matter."""

import re

import pytest
from contact_references import PIN_RADIUS, Reference, off

import linkages

LIMIT = 1e-8
"""In parts of the largest value of a run, at a tolerance of 1e-11: errors of steps add up, and the
motions that are compared forget at most two digits meanwhile."""
RTOL = 1e-11
ENDS = {
    "2-pin-in-hole": 0.08,
    "3-pendulum-with-friction": 0.2,
    "4-slider-crank-5000rpm": 0.004,
    "5-engine-crank-pin": 0.1,
    "6-free-crank-energy": 0.02,
}
OUTPUTS = (
    "clearance_offset", "clearance_offset_rate", "clearance_indentation", "clearance_force",
    "clearance_slip",
)  # fmt: skip
COLUMNS = {
    "clearance_offset": ("gap.offset_x", "gap.offset_y"),
    "clearance_offset_rate": ("gap.rate_x", "gap.rate_y"),
    "clearance_indentation": ("gap.indentation",),
    "clearance_force": ("gap.force",),
    "clearance_slip": ("gap.slip",),
}


def mechanism_of(name, definition=None):
    """The definition of a reference; where slip needs a radius, with it."""
    found = linkages.loads(definition or Reference(name).definition)
    radius = PIN_RADIUS.get(name)
    return found if radius is None else found.with_values({"clearances.gap.pin_radius": radius})


def run(name, end, *, mechanism=None, rtol=RTOL, method="dop853"):
    """Outputs at the times of a reference up to `end`, each of shape (times, numbers)."""
    times = [time for time in Reference(name).times if time <= end]
    data = linkages.simulate(
        mechanism or mechanism_of(name), times=[0.0, *times], rtol=rtol, method=method,
        outputs=OUTPUTS,
    ).data  # fmt: skip
    return {key: data[key][1:].to_numpy().reshape(len(times), -1) for key in OUTPUTS}


def errors(name, found):
    """Output → largest error at each time, in parts of the largest value."""
    reference = Reference(name)
    return {
        key: off(values, reference.column(*COLUMNS[key])[: len(values)])
        for key, values in found.items()
    }


def worst(name, found):
    return max(error.max() for error in errors(name, found).values())


@pytest.mark.parametrize("name", ENDS)
def test_states_forces_and_slip(name):
    for key, error in errors(name, run(name, ENDS[name])).items():
        assert (error < LIMIT).all(), (key, error)


@pytest.mark.slow_except("3-*", "5-*")
@pytest.mark.parametrize("method", ["vern9", "tsit5", "radau"])
@pytest.mark.parametrize("name", ENDS)
def test_other_methods(name, method):
    """Location, memory and restarts belong to no method; low orders are run to half way."""
    end = ENDS[name] if method == "vern9" else ENDS[name] / 2
    assert worst(name, run(name, end, method=method)) < LIMIT


@pytest.mark.parametrize("name", ENDS)
def test_error_falls_with_the_tolerance(name):
    """By a factor of at least 3 per decade on average over four decades."""
    end = min(ENDS[name], 0.05)
    loose, tight = (worst(name, run(name, end, rtol=rtol)) for rtol in (1e-7, 1e-11))
    assert tight < loose / 3**4


def reversed_bars(definition):
    """The same mechanism with the lines of its bars in the opposite order."""
    lines = definition.splitlines()
    first = lines.index("bars:") + 1
    last = next(k for k in range(first, len(lines)) if not lines[k].startswith("  "))
    lines[first:last] = reversed(lines[first:last])
    return "\n".join(lines)


@pytest.mark.parametrize("name", [name for name in ENDS if name[0] in "456"])
def test_order_of_bars_does_not_matter(name):
    definition = reversed_bars(Reference(name).definition)
    assert definition.index("rod:") < definition.index("crank:")
    assert worst(name, run(name, ENDS[name], mechanism=mechanism_of(name, definition))) < LIMIT


@pytest.mark.parametrize("name", [name for name in ENDS if name[0] in "246"])
def test_pin_and_hole_are_equal_without_friction(name):
    """Which of the two the bar carries matters to slip and to nothing else."""
    mechanism = mechanism_of(name).with_values({"clearances.gap.carries": "pin"})
    found = run(name, ENDS[name], mechanism=mechanism)
    del found["clearance_slip"]
    assert worst(name, found) < LIMIT


def test_pin_and_hole_differ_with_friction():
    """The lever arms of friction are R at the pin and R + ρ at the hole."""
    name = "3-pendulum-with-friction"
    mechanism = mechanism_of(name).with_values({"clearances.gap.carries": "pin"})
    assert worst(name, run(name, 0.05, mechanism=mechanism)) > 1e-4


def test_reversed_bars_are_a_different_text():
    texts = [Reference(name).definition for name in ENDS]
    changed = [reversed_bars(text) for text in texts if re.search(r"bars:\n", text)]
    assert len(changed) == 3
    assert not set(changed) & set(texts)
