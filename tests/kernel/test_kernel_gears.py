"""Gears: trains of wheels, also on arms that move, over several turns."""

import numpy as np
import pytest
from kernel_motion import carried_along, difference
from linkage_models import refusal, system_of, values

TIMES = np.linspace(0, 5.0, 101)

PLANETARY = """
joints: {O: [0, 0]}
bars:
  sun: {joints: [O, S], length: 0.1}
  arm: {joints: [O, P], length: 0.3}
  planet: {joints: [P, Q], length: 0.05}
  ring: {joints: [O, R], length: 0.5}
gears:
  - {bars: [sun, planet], carrier: arm, ratio: -0.5}
  - {bars: [planet, ring], carrier: arm, ratio: 0.4}
drives:
  sun: {angle: 0.2, speed: 6}
  KNOWN
"""


def test_a_planetary_train_with_a_ring_that_stands_still():
    """Willis: (ω_ring − ω_arm)/(ω_sun − ω_arm) = −z_sun/z_ring = −0.2, so ω_sun = 6 ω_arm."""
    standing = PLANETARY.split("gears")[0].replace("  ring: {joints: [O, R], length: 0.5}\n", "")
    of = system_of(
        standing
        + """
gears:
  - {bars: [ground, planet], carrier: arm, ratio: 2.5}
  - {bars: [planet, sun], carrier: arm, ratio: -2}
drives: {arm: {angle: 0.3, speed: 1.1}}
"""
    )
    sun, arm, planet = values(of, "bar_speed", 1.0)[:, 0]
    assert sun == pytest.approx(6 * arm, rel=1e-14)
    assert planet == pytest.approx(-1.5 * arm, rel=1e-14)
    angles = values(of, "bar_angle", TIMES)
    assert angles[0] == pytest.approx(6 * (0.3 + 1.1 * TIMES), rel=1e-14)


def test_a_planetary_train_as_a_differential():
    of = system_of(PLANETARY.replace("KNOWN", "arm: {angle: 0, speed: 1.7}"))
    sun, arm, planet, ring = values(of, "bar_speed", 1.0)[:, 0]
    assert (sun, arm) == (6.0, 1.7)
    assert planet == pytest.approx(1.7 - 0.5 * (6 - 1.7), rel=1e-14)
    assert ring == pytest.approx(1.7 - 0.2 * (6 - 1.7), rel=1e-14)
    q = values(of, "joint_position", TIMES)[-4:-2]
    angle = values(of, "bar_angle", TIMES)
    expected = 0.3 * np.exp(1j * angle[1]) + 0.05 * np.exp(1j * angle[2])
    assert q[0] + 1j * q[1] == pytest.approx(expected, abs=1e-14)


def test_ratios_count_whole_turns():
    """A ratio of 0.3 over five turns: angles modulo 2π would not do."""
    of = system_of("""
joints: {O: [0, 0], C: [1, 0]}
bars:
  first: {joints: [O, A], length: 0.1}
  second: {joints: [C, B], length: 0.1}
gears: [{bars: [first, second], ratio: 0.3, angle: 0.4}]
drives: {first: {angle: 1, speed: 6.5}}
""")
    angles = values(of, "bar_angle", TIMES)
    assert angles[0, -1] - angles[0, 0] > 5 * 2 * np.pi
    assert angles[1] == pytest.approx(0.3 * (1 + 6.5 * TIMES) + 0.4, abs=1e-14)
    place = values(of, "joint_position", TIMES)[-2:]
    assert place[0] == pytest.approx(1 + 0.1 * np.cos(angles[1]), abs=1e-14)


FIVE_BAR = """
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.6, 0]}
bars:
  first: {joints: [O, A], length: 0.3, mass: 0.5}
  left: {joints: [A, B], length: 0.5, mass: 0.7}
  right: {joints: [C, B], length: 0.45, mass: 0.6}
  second: {joints: [D, C], length: 0.15, mass: 0.4}
gears: [{bars: [first, second], ratio: RATIO, angle: 0.5}]
KNOWN: {first: {angle: 1.2, speed: 2}}
assembly: {B: [0.3, 0.7]}
"""


@pytest.mark.parametrize("ratio", [-1.0, 2.0, -0.5, 1.0])
def test_a_geared_five_bar_is_one_with_two_drives(ratio):
    geared = system_of(FIVE_BAR.replace("RATIO", repr(ratio)).replace("KNOWN", "drives"))
    assert geared.topology.mobility == 1
    drives = (
        f"drives: {{first: {{angle: 1.2, speed: 2}}, "
        f"second: {{angle: {ratio * 1.2 + 0.5}, speed: {ratio * 2}}}}}"
    )
    text = FIVE_BAR.split("gears")[0] + drives + "\nassembly: {B: [0.3, 0.7]}\n"
    driven = system_of(text)
    times = np.linspace(0, 0.2, 11)
    for name in ("joint_position", "joint_velocity", "joint_acceleration", "kinetic_energy"):
        expected, found = values(driven, name, times), values(geared, name, times)
        assert found == pytest.approx(expected, abs=1e-12 * max(1, np.abs(expected).max()))
    # the gear passes on what the second drive would give: its share of the power
    efforts = values(driven, "drive_effort", times)
    one = values(geared, "drive_effort", times)[0]
    assert one == pytest.approx(efforts[0] + ratio * efforts[1], abs=1e-11)


def test_a_free_geared_five_bar_keeps_its_energy():
    of = system_of(FIVE_BAR.replace("RATIO", "-0.5").replace("KNOWN", "free"))
    start, n = of.state, len(of.state) // 2
    second = of.evaluate(of.model.integrated_accelerations(of.model.changes))[:, 0]

    def energy(h):
        state = np.concatenate(
            [start[:n] + h * start[n:] + h * h / 2 * second, start[n:] + h * second]
        )
        names = ("kinetic_energy", "potential_energy")
        return sum(values(of, name, 0.0, state[:, None])[0, 0] for name in names)

    assert difference(energy, 1e-3) == pytest.approx(0.0, abs=1e-11)


COUPLED = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.5}
  coupler: {joints: [A, B], length: 1.2}
  rocker: {joints: [C, B], length: 1.1}
  wheel: {joints: [A, W], length: 0.1}
gears: [{bars: [coupler, wheel], carrier: crank, ratio: 0.37}]
drives: {crank: {angle: 0, speed: 4}}
assembly: {B: left}
"""


def test_a_wheel_that_follows_a_coupler():
    """A drag link: the coupler turns fully, its whole turns are carried along."""
    text = COUPLED.replace("length: 0.5", "length: 1.5").replace("length: 1.2", "length: 1.3")
    of = system_of(text.replace("length: 1.1", "length: 1.4"))
    assert of.topology.carried == ("coupler",)
    states = carried_along(of, TIMES)
    crank, coupler, _, wheel = values(of, "bar_angle", TIMES, states)
    assert np.abs(np.diff(coupler)).max() < 1.0  # no jumps of a turn
    assert abs(coupler[-1] - coupler[0]) > 4 * np.pi
    assert wheel == pytest.approx(0.37 * coupler + 0.63 * crank, abs=1e-13)
    speeds = values(of, "bar_speed", TIMES, states)
    assert speeds[3] == pytest.approx(0.37 * speeds[1] + 0.63 * speeds[0], abs=1e-12)
    assert coupler == pytest.approx(states[0], abs=1e-12)


def test_a_gear_that_closes_a_loop_is_iterated():
    """A four-bar whose drive turns the coupler against the crank by gears: no closed form."""
    of = system_of("""
joints: {O: [0, 0], C: [1, 0], D: [0, 0.6]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
  wheel: {joints: [D, W], length: 0.1}
gears: [{bars: [wheel, coupler], carrier: crank, ratio: 0.2, angle: 0.3}]
drives: {wheel: {angle: 0.5, speed: 1}}
assembly: {A: [0.2, 0.25], B: [1, 0.7]}
""")
    times = np.linspace(0, 0.6, 31)
    assert [b.kind for b in of.topology.solved_blocks] == ["N"]
    states = carried_along(of, times)
    assert np.abs(values(of, "closure_residual", times, states)).max() < 1e-13
    crank, coupler, _, wheel = values(of, "bar_angle", times, states)
    assert coupler == pytest.approx(0.2 * wheel + 0.8 * crank + 0.3, abs=1e-13)
    state = states[:, 10:11]
    for below, above in (("bar_angle", "bar_speed"), ("bar_speed", "bar_acceleration")):
        slope = difference(lambda h, n=below: values(of, n, times[10] + h, state)[:, 0], 2e-3)
        found = values(of, above, times[10], state)[:, 0]
        assert found == pytest.approx(slope, abs=1e-9 * max(1, np.abs(found).max()))


def test_all_wheels_are_known():
    text = FIVE_BAR.replace("RATIO", "2").replace("KNOWN: {first: {angle: 1.2, speed: 2}}",
        "drives: {first: {angle: 1, speed: 1}, second: {angle: 1, speed: 1}}")  # fmt: skip
    assert "second" in refusal(text)


def test_a_free_coordinate_is_not_chosen_among_followers():
    """Both wheels are on the ground and hinted at; the second follows from the first."""
    text = FIVE_BAR.replace("RATIO", "2").split("KNOWN")[0]
    hints = "assembly: {C: [0.6, 0.1], B: [0.3, 0.7], A: [0.1, 0.2]}"
    of = system_of(text + hints)
    assert of.chosen == ("first",)
    assert of.state == pytest.approx([np.arctan2(0.2, 0.1), 0.0], abs=1e-15)
