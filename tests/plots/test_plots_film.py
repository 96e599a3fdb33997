"""How motions are cut into frames, and how frames become a GIF."""

import numpy as np
import pytest
from PIL import Image

from linkages.plots.films.animation import palette_of, write_gif
from linkages.plots.films.film import MOST_FRAMES, film_of, natural_pace
from linkages.plots.films.film_layout import PageLayout
from linkages.plots.mechanism.plane_view import Box


@pytest.mark.parametrize(
    ("duration", "slow", "pace"),
    [
        (4.0, 1.0, "real time"),
        (12.0, 1.0, "real time"),
        (2.0, 2.0, "slowed down 2×"),
        (0.08, 50.0, "slowed down 50×"),
        (0.03, 200.0, "slowed down 200×"),
        (20.0, 0.5, "sped up 2×"),
        (1e4, 1e-3, "sped up 1000×"),
    ],
)
def test_a_pace_that_can_be_followed(duration, slow, pace):
    assert natural_pace(duration) == pytest.approx(slow)
    film = film_of(duration)
    assert film.pace == pace
    assert 4.0 <= film.seconds <= 12.0
    assert film.frames == round(film.seconds * 25)


def test_frames_start_where_they_should_and_leave_out_the_end():
    film = film_of(2.0, start=0.5, duration=1.0, slow=2.0, fps=10.0)
    np.testing.assert_allclose(film.times, 0.5 + 0.05 * np.arange(20))


def test_backward_motions():
    film = film_of(-2.0, slow=1.0, fps=4.0)
    np.testing.assert_allclose(film.times, -0.25 * np.arange(8))
    time = np.linspace(0, -2, 9)
    np.testing.assert_array_equal(film.samples(time), np.arange(8))


def test_each_frame_shows_the_nearest_sample():
    film = film_of(1.0, slow=1.0, fps=10.0)
    time = np.array([0.0, 0.14, 0.16, 0.29, 0.5, 0.91, 1.0])
    distance = np.abs(time[:, None] - film.times)
    np.testing.assert_array_equal(film.samples(time), distance.argmin(axis=0))


def test_too_many_frames():
    film_of(MOST_FRAMES / 25, slow=1.0)
    with pytest.raises(ValueError, match="more than 20000"):
        film_of(MOST_FRAMES / 25 + 1, slow=1.0)


def pictures(count, shape=(20, 30)):
    """A red square that moves over white."""
    found = np.full((count, *shape, 3), 255, dtype=np.uint8)
    for index in range(count):
        found[index, 5:9, index : index + 4] = (200, 0, 0)
    return found


def test_frames_of_a_gif_are_as_they_were(tmp_path):
    shown = pictures(9)
    twice = [*shown, shown[-1]]  # the last one: nothing changes
    write_gif(tmp_path / "a.gif", twice, palette_of(shown), 30.0)
    with Image.open(tmp_path / "a.gif") as image:
        assert image.info["loop"] == 0
        assert image.n_frames == 10
        times = []
        for index, picture in enumerate(twice):
            image.seek(index)
            times.append(image.info["duration"])
            np.testing.assert_array_equal(np.asarray(image.convert("RGB")), picture)
    # 30 frames a second in hundredths: 3, 4, 3, … with no error that adds up
    assert sum(times) == 330
    assert set(times) == {30, 40}


def test_what_rests_costs_no_bytes(tmp_path):
    rng = np.random.default_rng(0)
    shown = pictures(2, (200, 300))
    shown[:, 50:] = rng.integers(0, 2, (150, 300, 1)) * 255  # does not compress
    sizes = []
    for count in (1, 2):
        write_gif(tmp_path / "a.gif", shown[:count], palette_of(shown), 10.0)
        sizes.append((tmp_path / "a.gif").stat().st_size)
    assert sizes[1] - sizes[0] < 100 < sizes[0]


def test_a_palette_keeps_rare_colours_of_their_own():
    picture = np.full((100, 100, 3), 255, dtype=np.uint8)
    for shade in range(60):  # many greys near each other, and a little green
        picture[shade, :50] = 100 + shade
    picture[90, :10] = (0, 160, 90)
    palette = np.reshape(palette_of([picture], colours=8).getpalette()[:24], (8, 3))
    assert [255, 255, 255] in palette.tolist()
    assert np.abs(palette - (0, 160, 90)).max(axis=1).min() <= 4


@pytest.mark.parametrize("count", range(8))
@pytest.mark.parametrize("shape", [(1.0, 1.0), (5.0, 1.0), (0.2, 1.0), (1.0, 0.0)])
@pytest.mark.parametrize("size", [None, (14.0, 14.0)])
def test_nothing_covers_anything(count, shape, size):
    layout = PageLayout.of(Box.around([(0, 0), shape]), count, size)
    assert size in (None, layout.size)
    assert len(layout.insets) == count
    page = np.array(layout.size)
    boxes = [
        (np.array(r[:2]) * page, np.array(r[:2]) * page + np.array(r[2:]) * page)
        for r in (layout.main, *layout.insets)
    ]
    for index, (low, high) in enumerate(boxes):
        assert (low >= 0).all()
        assert (high <= page + 1e-9).all()
        for other_low, other_high in boxes[:index]:
            assert ((high <= other_low + 1e-9) | (other_high <= low + 1e-9)).any()
    for low, high in boxes[1:]:
        width, height = high - low
        assert width == pytest.approx(height)
