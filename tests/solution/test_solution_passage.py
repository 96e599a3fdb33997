"""What a step through a change point must show to be taken for smooth."""

from types import SimpleNamespace

import numpy as np
import pytest

from linkages.solution.change_points import Crossing, vanishes
from linkages.solution.driven_limits import Limits


def goes_on(margins, rates, blocks=(0,)):
    """Whether margins and rates at the two ends of a step, (2, blocks) each, belong together."""
    count = len(margins[0])
    crossing = Crossing.__new__(Crossing)
    crossing._flow = SimpleNamespace(coordinates=0, margin_scale=np.ones(count))
    first, last = (np.array([*m, *r], dtype=float) for m, r in zip(margins, rates, strict=True))
    return crossing._continues(first, last, blocks)


@pytest.mark.parametrize(
    ("rate_behind", "smooth"),
    [(-1.0, True), (-1.4, True), (-0.6, True), (-1.6, False), (-0.4, False), (-4.0, False),
     (2.0, False)],
)  # fmt: skip
def test_a_margin_goes_on_at_about_its_rate(rate_behind, smooth):
    """A rate may change by half of itself: beyond that another motion has been met."""
    assert goes_on([[0.2], [-0.2]], [[-1.0], [rate_behind]]) is smooth


def test_exactly_the_margins_concerned_change_their_signs():
    steady = [[-1.0, 0.1], [-1.0, 0.1]]
    assert goes_on([[0.2, 0.5], [-0.2, 0.5]], steady)
    assert not goes_on([[0.2, 0.5], [-0.2, -0.5]], steady)
    assert not goes_on([[0.2, 0.5], [0.2, 0.5]], steady)


@pytest.mark.parametrize(("rate", "smooth"), [(-1.4, True), (-1.6, False), (-4.0, False)])
def test_the_same_holds_for_driven_motions(rate, smooth, monkeypatch):
    """Margins and rates on both sides are those of a system that is made up."""

    def values(self, times):
        behind = bool(self._flipped)
        margin, own = (-0.06, rate) if behind else (0.06, -1.0)
        return np.ones((1, 1)), np.full((1, len(times)), margin), np.full((1, len(times)), own)

    def limits(_self, _system, flipped, _fastest):
        _self._flipped, _self._margin_blocks, _self._system, _self._fastest = flipped, [0], 0, 1.0

    monkeypatch.setattr(Limits, "__init__", limits)
    monkeypatch.setattr(Limits, "_values", values)
    monkeypatch.setattr(Limits, "_vanish", lambda *_: True)
    assert Limits(0, (), 1.0)._smooth(1.0, 0.06, (0,)) is smooth


@pytest.mark.parametrize(("least", "there"), [(0.0, True), (1e-11, True), (3e-10, False),
                                              (-3e-10, False), (1e-4, False)])  # fmt: skip
def test_a_margin_must_vanish(least, there):
    """Its square is smooth; 1e-5 is the margin that counts as singular, so 1e-10 its square."""
    times = np.array([-1.0, -0.8, -0.6, -0.4, -0.25, 0.25, 0.4, 0.6, 0.8, 1.0])
    assert vanishes(times, np.sqrt(times**2 + least), 0.01) is there
