"""Random mechanisms with contact in one to three clearances, against absolute coordinates."""

import numpy as np
import pytest
from absolute_contact import AbsoluteContact
from absolute_legs import motion
from random_contact import ENDS, definition, kind

import linkages

LIMIT = 1e-8
"""In parts of the largest value; both integrate at 1e-12, and touches amplify what they differ by.
Most differ by some 1e-11."""
RTOL = 1e-12
SEEDS = [seed for seed in range(24) if seed != 3]  # whose pins fly to the end
OUTPUTS = ("clearance_offset", "clearance_offset_rate", "clearance_slip", "clearance_force")


def check(seed):
    text = definition(seed)
    times = np.linspace(0.0, ENDS[kind(seed)], 6)
    model = AbsoluteContact(text)
    own = motion(model, times[1:], rtol=RTOL)
    assert sum(event.kind == "touch" for event in own.events) >= 1, text
    data = linkages.simulate(
        linkages.loads(text), times=times, rtol=RTOL,
        outputs=[*OUTPUTS, "joint_position"],
    ).data.isel(time=slice(1, None))  # fmt: skip
    gaps = range(len(model.gaps))
    offsets = np.array([model.offsets(y) for y in own.states])
    walls = [[model.wall(y, k) for k in gaps] for y in own.states]
    forces = [
        [model.force(k, walls[i][k], own.modes[i][k]) for k in gaps] for i in range(len(walls))
    ]
    expected = {
        "clearance_offset": offsets[:, 0],
        "clearance_offset_rate": offsets[:, 1],
        "clearance_slip": np.array([[wall.slip for wall in row] for row in walls]),
        "clearance_force": np.array(forces),
    }
    for name, values in expected.items():
        off = np.abs(data[name].to_numpy() - values).max()
        size = np.abs(values).max()
        # a force is as wrong as its indentation, which is a tenth to a hundredth of the offset
        assert off <= LIMIT * (100 if name == "clearance_force" else 1) * size, (name, off, text)
    check_places(model, own.states, data)


def check_places(model, states, data):
    """Joints of the first points of all bodies: nothing but the gaps is open."""
    bodies = model.bodies
    for state, (_, sample) in zip(states, data.groupby("time"), strict=True):
        arms = bodies.arms(model.places(state))
        placed = bodies.placed(model.places(state), arms)
        end = placed[:, 2 * bodies.pins + 1 :: 2].T
        for k, gap in enumerate(model.gaps):
            joint = sample.joint_position.sel(joint=f"{gap.joint}.{gap.name}").to_numpy().ravel()
            assert np.abs(joint - end[k]).max() < LIMIT * gap.size * 10


@pytest.mark.slow_except("1")
@pytest.mark.parametrize("seed", SEEDS)
def test_against_absolute_coordinates(seed):
    check(seed)


def test_seeds_draw_everything():
    """One, two and three clearances, with and without friction, and every law."""
    gaps = [AbsoluteContact(definition(seed)).gaps for seed in range(24)]
    assert {len(found) for found in gaps} == {1, 2, 3}
    texts = "".join(definition(seed) for seed in range(40))
    for word in ("friction", "carries: pin", "carries: hole", "gravity", "torque", "force"):
        assert word in texts
    assert sum(f"contact: {law}\n" in texts for law in ("exact", "hertz", "kelvin-voigt")) == 3


@pytest.mark.slow_except("3-1", "101-1")
@pytest.mark.parametrize("seed", [1, 4, 6, 7])
@pytest.mark.parametrize("samples", [3, 101])
def test_means_of_rates_are_what_they_change(seed, samples):
    """A touch lasts a few microseconds, in which the acceleration is largest."""
    mechanism = linkages.loads(definition(seed))
    end = ENDS[kind(seed)]
    solution = linkages.simulate(mechanism, end=end, samples=samples)
    name = [name for name, bar in mechanism.bodies.items() if bar.rotates][-1]
    for rate, place in (("speed", "angle"), ("acceleration", "speed")):
        change = linkages.measure(solution, f"final({name}.{place}) - at(0 s, {name}.{place})")
        mean = linkages.measure(solution, f"mean({name}.{rate})")
        largest = linkages.measure(solution, f"max(abs({name}.{rate}))")
        # accelerations of states that are interpolated within steps at the default tolerance
        assert abs(mean - change / end) <= 1e-9 * largest
