"""Libration, rotation and tumbling of angles that are known."""

import numpy as np
import pytest

from linkages.chaos.periods import Kind, classify_angle, refined

TIME = np.linspace(0.0, 100.0, 8001)


def test_resting():
    found = classify_angle(TIME, np.full_like(TIME, 9.0))
    assert found.kind is Kind.RESTING


@pytest.mark.parametrize("amplitude", [1e-3, 1.0, 3.1])
def test_libration(amplitude):
    """Wherever it is, and even if it librates across the top: its range is below a turn."""
    for middle in (0.0, np.pi, 40.0):
        found = classify_angle(TIME, middle + amplitude * np.sin(TIME))
        assert found.kind is Kind.LIBRATION
        assert found.forward == found.backward == 0
        assert abs(found.rate) < 1e-3 * amplitude


@pytest.mark.parametrize("sense", [1, -1])
def test_rotation(sense):
    """The weights find the mean rate to 1e-5 in 16 oscillations; end points alone to 1e-2."""
    found = classify_angle(TIME, sense * (2.0 * TIME + 0.9 * np.sin(TIME) + 0.3 * np.cos(3 * TIME)))
    assert found.kind is Kind.ROTATION
    assert found.rate == pytest.approx(2.0 * sense, abs=1e-5)
    assert found.rate_error < 1e-3
    assert (found.forward, found.backward)[::sense] == (31, 0)  # 200 rad are 31.8 turns


def test_error_of_the_rate_is_the_difference_of_the_halves():
    """2 rad/s for half of the time, then 3 rad/s; a bend in the middle costs a sample's share."""
    found = classify_angle(TIME, 2.0 * TIME + np.clip(TIME - 50, 0, None))
    assert found.rate_error == pytest.approx(1.0, abs=1e-3)


def test_rotation_that_steps_back():
    """An angle may go back on its way: 0.55 rad here, and still it rotates."""
    found = classify_angle(TIME, 1.0 * TIME + 1.5 * np.sin(TIME))
    assert found.kind is Kind.ROTATION
    assert found.backward == 0


def test_tumbling_in_both_senses():
    angle = 15 * np.sin(2 * np.pi * TIME / 50)  # up 30 rad, down 30 rad
    found = classify_angle(TIME, angle)
    assert found.kind is Kind.MIXED
    assert found.forward == 8  # 2 to the first top, 4 from trough to top, 2 to the end
    assert found.backward == 8


def test_libration_and_then_a_turn():
    """Sixty seconds of libration between turns in one sense are no rotation."""
    turning = np.clip(TIME - 70, 0, None) * 3
    found = classify_angle(TIME, np.sin(TIME) + turning)
    assert found.kind is Kind.MIXED
    assert found.backward == 0


def test_wrapped_angles_are_refused():
    with pytest.raises(ValueError, match="half a turn or more after time"):
        classify_angle(TIME, np.remainder(TIME, 2 * np.pi))
    with pytest.raises(ValueError, match="8 or more"):
        classify_angle(TIME[:7], TIME[:7])
    with pytest.raises(ValueError, match="increase"):
        classify_angle(TIME[::-1], TIME)


def test_several_turns_between_samples_are_counted_where_turns_are_known():
    """A link in a small clearance turns faster than its motion is sampled."""
    turning = 2 * np.pi * 3.7 * np.arange(len(TIME)) + np.sin(TIME)
    found = classify_angle(*refined(TIME, turning))
    assert found.kind is Kind.ROTATION
    assert found.forward == int(3.7 * (len(TIME) - 1) + np.sin(TIME[-1]) / (2 * np.pi))
    assert found.rate == pytest.approx(2 * np.pi * 3.7 / (TIME[1] - TIME[0]), rel=1e-4)


def test_slow_angles_are_not_refined():
    time, angle = refined(TIME, np.sin(TIME))
    assert time is TIME
    assert len(angle) == len(TIME)


def test_error_of_a_rate_that_changes():
    """Of θ = t² the halves of (0, T) turn at T/2 and 3T/2, their weights being symmetric."""
    time = np.linspace(0, 10, 1001)
    found = classify_angle(time, time**2)
    assert found.rate == pytest.approx(10, rel=1e-9)
    assert found.rate_error == pytest.approx(10, rel=1e-9)
