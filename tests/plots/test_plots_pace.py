"""Whether a film says that it is too fast to show what it shows."""

import re

import numpy as np
import pytest

import linkages
from linkages.plots.films.film import FEWEST_FRAMES, fastest, film_of, too_fast

OUTPUTS = ["joint_position", "bar_angle", "slider_position", "clearance_angle"]


@pytest.fixture(scope="module")
def ninebar():
    return linkages.simulate(linkages.load("ninebar"), samples=721, outputs=OUTPUTS)


def test_swings_between_frames_are_counted(ninebar):
    """80 frames for 2 s, in which the clearance swings 179 times as 20 001 samples show."""
    fine = linkages.simulate(linkages.load("ninebar"), samples=20_001, outputs=["clearance_speed"])
    speed = fine.data["clearance_speed"].to_numpy()[:, 0]
    swings = np.count_nonzero(np.diff(np.sign(speed))) / 2
    assert swings == pytest.approx(179, abs=1)
    pace = fastest(ninebar, film_of(2.0, fps=20, slow=2))
    assert (pace.name, pace.turns) == ("r1", False)
    assert pace.rate == pytest.approx(swings / 80, abs=0.05)


def test_what_is_advised_shows_the_swing(ninebar):
    note = too_fast(ninebar, film_of(2.0, fps=20, slow=2))
    assert note.startswith("r1 swings 2.2 times between frames")
    slow, duration = (float(text) for text in re.findall(r"--\w+ (\S+)", note))
    film = film_of(2.0, fps=20, start=0.1, slow=slow, duration=duration)
    assert too_fast(ninebar, film) == ""
    # half a swing more or less of ten is counted, but for rounding
    assert fastest(ninebar, film).rate * FEWEST_FRAMES <= 1.05 * (1 + 1e-12)
    assert 4 <= film.seconds <= 12


def test_turns_between_frames_are_counted():
    """A crank at 3000 rpm turns 12.5 times between frames that are a quarter of a second apart."""
    mechanism = linkages.load("slider-crank", set={"drives.crank.speed": "3000 rpm"})
    solution = linkages.simulate(mechanism, end=2.0, samples=2001, outputs=OUTPUTS[:3])
    pace = fastest(solution, film_of(2.0, fps=4, slow=1))
    assert pace == ("crank", pytest.approx(12.5, rel=1e-6), True, False)


def test_advice_keeps_to_a_motion_that_is_short():
    """A crank turns twice in a second: a film of it all, five times faster, has five frames."""
    solution = linkages.simulate(linkages.load("scotch-yoke"), end=1.0, outputs=OUTPUTS[:3])
    note = too_fast(solution, film_of(1.0, slow=0.2))
    assert note.endswith("--slow 1 shows it in 1 s")
    # a film of a single frame is shorter than its step; turns still count by time
    one, many = (fastest(solution, film_of(1.0, slow=slow)) for slow in (0.01, 0.2))
    assert one.rate == pytest.approx(20 * many.rate, rel=1e-6)


def test_a_film_that_can_be_followed_has_no_note():
    solution = linkages.simulate(linkages.load("four-bar"), outputs=OUTPUTS[:2])
    assert too_fast(solution, film_of(1.0)) == ""


def test_nothing_that_turns_is_no_fault():
    solution = linkages.simulate(linkages.load("four-bar"), outputs=OUTPUTS[:1])
    assert fastest(solution, film_of(1.0)) is None
