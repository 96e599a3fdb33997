"""Animations: what frames show, read back from the files."""

import os
import shutil
import signal
import subprocess
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

import linkages
from linkages.plots.films.animation import animate
from linkages.plots.films.film import film_of, scenes
from linkages.plots.films.stage import Stage
from linkages.reading.document import shipped

# All that is drawn of moving parts, carried by slots, springs, welds and gears.
EVERYTHING = """
joints: {O: [0, 0], D: [0.5, 0], G: [0.9, 0], S: [0.9, 0.35]}
bars:
  crank: {joints: [O, A], length: 0.12}
  coupler: {points: {A: [0, 0], B: [0.4, 0], P: [0.2, 0.15]}}
  rocker: {joints: [D, B], length: 0.3}
  horn: {joints: [D, H], length: 0.15}
  pinion: {joints: [G, K], length: 0.06}
sliders: {block: {joint: T, on: horn}, ram: {joint: Q, through: [-0.3, 0.1], angle: 90 deg}}
welds: {D: {bars: [rocker, horn], angle: 60 deg}}
gears: [{bars: [rocker, pinion], ratio: -2}]
masses: {H: 0.5}
springs: [{between: [S, B], stiffness: 500, length: 0.3, damping: 5}, {bar: rocker, stiffness: 5}]
dampers: [{slider: ram, damping: 3}, {joint: A, damping: 0.1}]
drives:
  crank: {angle: 0.5, speed: pi}
  ram: {position: 0.2, speed: 0.1}
  block: {position: 0.05, speed: 0.01}
assembly: {B: [0.5, 0.3]}
simulate: {end: 1, samples: 21}
"""


def run(name, **options):
    """A few samples of the beginning of a shipped mechanism's motion."""
    mechanism = linkages.load(name)
    end = 1e-3 * mechanism.simulation.end if mechanism.initial else mechanism.simulation.end
    turning = any(body.rotates for body in mechanism.bodies.values())
    outputs = ["joint_position", *(["bar_angle"] if turning else [])]
    options = {"samples": 5, "end": end, "outputs": outputs, "throw": False} | options
    return linkages.simulate(mechanism, **options)


def press(**options):
    """The nine-bar with its clearance, for the time in which the clearance swings."""
    outputs = ["joint_position", "bar_angle", "slider_position", "clearance_force"]
    options = {"end": 0.02, "samples": 41, "rtol": 1e-6, "outputs": outputs} | options
    return linkages.simulate(linkages.load("ninebar"), **options)


def frames(path):
    with Image.open(path) as image:
        found = []
        for index in range(image.n_frames):
            image.seek(index)
            found.append(np.asarray(image.convert("RGB")).astype(int))
        return found


def stage_of(solution, film=None, size=None, dpi=60.0):
    film = film or film_of(float(solution.data["time"][-1]))
    return Stage(solution.data, solution.mechanism, film, size, dpi)


@pytest.mark.slow_except("four-bar", "ninebar")
@pytest.mark.parametrize("name", shipped())
def test_every_shipped_mechanism_moves(name, tmp_path):
    path = tmp_path / "a.gif"
    solution = run(name)
    film = animate(solution, path, fps=4, slow=1 / float(solution.data["time"][-1]), dpi=40)
    first, *_, last = frames(path)
    assert film.frames == 4
    assert (first != last).any(axis=2).mean() > 1e-4


def test_one_of_everything_moves(tmp_path):
    solution = linkages.simulate(linkages.loads(EVERYTHING))
    animate(solution, tmp_path / "a.gif", fps=5, slow=1, dpi=50)
    pictures = frames(tmp_path / "a.gif")
    assert len(pictures) == 5
    assert all((a != b).any() for a, b in pairwise(pictures))


def test_only_what_changed_is_drawn_and_nothing_stays_behind():
    # A frame over the background of another must be the frame by itself.
    solution = press()
    stage = stage_of(solution)
    wanted = stage_of(solution).picture(7).copy()
    stage.picture(30)
    np.testing.assert_array_equal(stage.picture(7), wanted)


@pytest.mark.slow
def test_a_gif_shows_what_was_drawn(tmp_path):
    # Colours come from a palette of 32 shades; 40 of 255 is half the distance of neighbours there.
    solution = press()
    film = animate(solution, tmp_path / "a.gif", fps=5, slow=100, dpi=60)
    drawn_from = scenes(solution, film)
    stage = stage_of(replace(solution, data=drawn_from.data), film)
    for index, shown in zip(drawn_from.places, frames(tmp_path / "a.gif"), strict=True):
        drawn = stage.picture(int(index))[..., :3].astype(int)
        assert np.quantile(np.abs(shown - drawn), 0.999) < 40


def test_the_pin_moves_in_its_hole_and_the_force_pushes_at_its_wall():
    from linkages.plots.films.insets import HOLE, LONGEST, PIN, WALL, journals

    solution = press()
    (contact,) = journals(solution.data, solution.mechanism)
    assert (contact.name, contact.joint, contact.size) == ("r1", "C", 0.15e-3)
    # pin and hole stay in contact, and the pin lies where the clearance link comes from;
    # 0.15 mm are the difference of coordinates of a metre, which have 1e-16 m
    np.testing.assert_allclose(np.hypot(*contact.offset.T), 1.0, rtol=1e-11)
    assert pytest.approx(1.0) == HOLE - PIN
    angle = linkages.simulate(solution.mechanism, end=0.02, samples=41, rtol=1e-6).data
    alpha = angle["clearance_angle"].sel(clearance="r1").to_numpy()
    np.testing.assert_allclose(
        contact.offset, -np.column_stack((np.cos(alpha), np.sin(alpha))), atol=1e-6
    )
    stage = stage_of(solution)
    stage.picture(20)
    (inset,) = stage._insets
    pin, *_, arrow, text, _ = inset.artists
    assert inset.scale.root
    np.testing.assert_allclose(pin.center, contact.offset[20])
    tip = arrow.get_xy()[3]
    force, largest = contact.forces[20, 0], np.abs(contact.forces).max()
    np.testing.assert_allclose(
        tip - WALL * contact.offset[20],
        contact.offset[20] * LONGEST * np.sqrt(force / largest),
        atol=1e-9,
    )
    assert text.get_text() == f"{force:.3g} N"


def test_lost_contact_is_said():
    solution = press()
    solution.data["clearance_force"] *= -1
    stage = stage_of(solution)
    stage.picture(0)
    *_, text, _ = stage._insets[0].artists
    assert text.get_text().startswith("−")
    assert text.get_text().endswith(" N\nno contact")


def test_times_pace_and_scale_are_written():
    stage = stage_of(press(), film_of(0.02, slow=50))
    stage.picture(40)
    written = {text.get_text() for ax in stage._canvas.figure.axes for text in ax.texts}
    assert stage._clock.get_text() == "t = 0.0200 s"
    assert {"slowed down 50×", "0.2 mm"} <= written
    inset = stage._canvas.figure.axes[-1]
    assert inset.get_title(loc="left").startswith("r1 at C, ")


def test_a_failure_or_ctrl_c_leaves_nothing_behind(tmp_path):
    path = tmp_path / "a.gif"
    path.write_bytes(b"an older film")

    def interrupt(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate(run("four-bar"), path, fps=2, watch=interrupt)
    assert os.listdir(tmp_path) == ["a.gif"]
    assert path.read_bytes() == b"an older film"


def test_ctrl_c_waits_for_the_end_of_a_frame(tmp_path):
    # In the midst of drawing, matplotlib turns it into a ValueError of its own.
    done = []

    def hit(fraction):
        done.append(fraction)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        animate(run("four-bar"), tmp_path / "a.gif", fps=2, watch=hit)
    assert len(done) == 1
    assert os.listdir(tmp_path) == []
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.avi", {}, "unknown format 'avi'; expected one of: gif, webp, mp4"),
        ("a.gif", {"fps": 51}, "at most 50 frames per second, found 51"),
        ("a.gif", {"fps": 0}, "fps must be at least 0.01, found 0"),
        ("a.gif", {"slow": float("nan")}, "slow must be > 0"),
        ("a.gif", {"duration": -1}, "duration must be > 0 s"),
        ("a.gif", {"duration": 2}, "duration reaches beyond the end"),
        ("a.gif", {"start": 1}, "start must be a time from 0 to before 1 s"),
        ("a.gif", {"slow": 1e6}, "frames are more than 20000"),
        ("a.gif", {"size": (90, 90)}, "90x90 pixels are too small for this picture"),
        ("a.gif", {"size": (9000, 90)}, "size must be from 2 to 4096 pixels"),
        ("a.gif", {"dpi": 1}, "dpi must be from 20 to 1000"),
    ],
)
def test_arguments_that_make_no_film(tmp_path, name, options, message):
    with pytest.raises(ValueError, match=message):
        animate(run("four-bar"), tmp_path / name, **options)
    assert os.listdir(tmp_path) == []


def test_data_without_joints(tmp_path):
    solution = run("slider-crank", outputs=["slider_position"])
    with pytest.raises(ValueError, match="no samples of joint_position"):
        animate(solution, tmp_path / "a.gif")


def test_frames_show_their_own_times_however_a_motion_was_sampled():
    """Three samples suffice; where the motion was, a run at those times says."""
    coarse = press(samples=3)
    film = film_of(0.02, start=0.004, slow=100, fps=10)
    shown = scenes(coarse, film)
    np.testing.assert_allclose(shown.data["time"][shown.places], film.times, rtol=0, atol=1e-15)
    fine = linkages.simulate(
        coarse.mechanism, times=film.times, rtol=1e-6, outputs=["joint_position"]
    )
    np.testing.assert_array_equal(
        shown.data["joint_position"][shown.places], fine.data["joint_position"]
    )


@pytest.mark.slow
def test_clearances_have_a_pace_of_their_own(tmp_path):
    """The whole motion in a film in which the clearance swings twice between frames."""
    solution = linkages.simulate(
        linkages.load("ninebar"), rtol=1e-6, outputs=["joint_position", "clearance_angle"]
    )
    film = animate(solution, tmp_path / "a.gif", dpi=30, fps=10)
    assert film.slow == pytest.approx(2.0)
    assert film.near.slow >= 24 * 89 / 10  # 24 frames for each of 89 swings in a second
    shown = scenes(solution, film)
    stage = stage_of(replace(solution, data=shown.data), film)
    stage.picture(shown.places[30], shown.near[30])
    time = f"t = {film.near.times[30]:.5f}"[:-1]
    assert stage._clock.get_text() == f"t = {film.times[30]:.2f} s"
    assert stage._insets[0]._moment.get_text().startswith(time)
    assert stage._insets[0]._moment.get_text().endswith(f" s\n{film.near.pace}")


def test_names_move_and_a_cursor_stands_at_the_time():
    solution = run("four-bar", samples=9)
    strips = [("A.x", solution.data["joint_position"].sel(joint="A", axis="x"))]
    film = film_of(float(solution.data["time"][-1]))
    stage = Stage(solution.data, solution.mechanism, film, names=True, strips=strips)
    for index in (0, 5):
        stage.picture(index)
        place = solution.data["joint_position"].sel(joint="A")[index]
        written = np.array(stage._names["A"].xy) / stage._factor
        np.testing.assert_allclose(written, place)
        x = stage._strips[0].cursor.get_xdata()[0]
        assert x == pytest.approx(
            float(solution.data["time"][index]) * stage._strips[0]._scale.factor
        )


@pytest.mark.slow_except("60")
@pytest.mark.parametrize("dpi", [60, 73, 96])
def test_a_bare_picture_has_the_whole_frame_of_an_inset(dpi):
    solution = press()
    stage = Stage(solution.data, solution.mechanism, film_of(0.1), dpi=dpi, bare=True)
    red = stage.picture(0)[..., 0]
    assert (red[:, -1] == 255).all()
    assert (red[:, -6:] < 128).mean(axis=0).max() > 0.9  # the line at the right


@pytest.mark.slow
def test_a_webp_shows_exactly_what_was_drawn(tmp_path):
    solution = press()
    film = animate(solution, tmp_path / "a.webp", fps=30, slow=20, dpi=60)
    shown = scenes(solution, film)
    stage = stage_of(replace(solution, data=shown.data), film)
    with Image.open(tmp_path / "a.webp") as image:
        assert image.n_frames == film.frames == 12
        durations = []
        for place, picture in zip(shown.places, frames(tmp_path / "a.webp"), strict=True):
            np.testing.assert_array_equal(picture, stage.picture(place)[..., :3])
            image.seek(len(durations))
            image.load()
            durations.append(image.info["duration"])
    assert sum(durations) == 400


def test_the_size_is_as_wished(tmp_path):
    animate(run("four-bar"), tmp_path / "a.gif", size=(401, 300), dpi=50, fps=1)
    with Image.open(tmp_path / "a.gif") as image:
        assert image.size == (400, 300)  # videos need even sides, and GIFs get the same


def test_mp4_without_ffmpeg_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ValueError, match="needs the program ffmpeg, which was not found; install"):
        animate(run("four-bar"), tmp_path / "a.mp4")
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(not shutil.which("ffmpeg"), reason="needs ffmpeg")
def test_mp4_has_all_frames(tmp_path):
    path = tmp_path / "a.mp4"
    film = animate(run("four-bar"), path, fps=5, dpi=40)
    command = [
        "ffmpeg",
        "-loglevel",
        "error",
        "-i",
        path,
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-",
    ]
    video = subprocess.run(command, check=True, capture_output=True).stdout
    width, height = stage_of(run("four-bar"), dpi=40.0).size
    pictures = np.frombuffer(video, np.uint8).reshape(-1, height, width, 3)
    assert len(pictures) == film.frames
    assert (np.abs(pictures[0].astype(int) - pictures[-1]) > 60).any()


@pytest.mark.skipif(os.name == "nt", reason="needs a shell script as a program")
def test_what_ffmpeg_complains_about_is_said(tmp_path, monkeypatch):
    program = tmp_path / "bin" / "ffmpeg"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\necho 'Unknown encoder' >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}/bin{os.pathsep}/usr/bin")
    with pytest.raises(OSError, match="ffmpeg failed: Unknown encoder"):
        animate(run("four-bar"), tmp_path / "out" / "a.mp4", fps=5, dpi=40)
    assert os.listdir(tmp_path / "out") == []
