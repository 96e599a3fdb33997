"""Forces and blocks in films: where they are drawn, and how large."""

import numpy as np
import pytest
from matplotlib.text import Text
from PIL import Image

import linkages
from linkages.components.contributed.normal_forces import CORNERS
from linkages.plots.films.animation import animate
from linkages.plots.films.film import film_of
from linkages.plots.films.force_arrows import (
    LONGEST,
    SHORTEST,
    ArrowScale,
    arrow,
    loads,
    reactions,
    ring,
)
from linkages.plots.films.insets import HEIGHT, RAIL, blocks
from linkages.plots.films.stage import Stage
from linkages.stamps import stamped

PLAY = """
name: block with play
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 153 mm, mass: 0.038}
  rod: {joints: [A, B], length: 306 mm, mass: 0.038}
sliders: {ram: {joint: B, through: O, angle: 30 deg, mass: 0.076, inertia: 2.7e-6}}
clearances:
  play: {slider: ram, size: 1 mm, length: 100 mm, height: 50 mm, contact: exact,
         restitution: 0.4, stiffness: 1e8, offset: 0.2 mm, angle: 0.01}
drives: {crank: {angle: 0, speed: 150 rad/s}}
assembly: {B: [0.4, 0.22]}
simulate: {end: 0.02, samples: 41, rtol: 1e-6}
"""

PUSHED = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.4}}
drives: {crank: {angle: 0, speed: pi}}
loads:
  - {joint: A, force: [30 * t, 40 * t]}
  - {joint: A, on: crank, force: [0, 5]}
  - {bar: crank, torque: -2 - 8*t}
simulate: {end: 1, samples: 11}
"""


def test_a_block_touches_its_rails_where_corners_do():
    solution = linkages.simulate(linkages.loads(PLAY), outputs="all")
    data = solution.data
    (block,) = blocks(data, solution.mechanism)
    angle = block.shapes[0].direction.angle
    assert (block.name, block.joint, angle) == ("play", "B", pytest.approx(np.radians(30)))
    stage = Stage(data, solution.mechanism, film_of(0.02), dpi=60.0)
    (inset,) = stage._insets
    turn = np.array([[np.cos(angle), -np.sin(angle)],
                     [np.sin(angle), np.cos(angle)]])  # fmt: skip
    indented = data["clearance_indentation"].to_numpy() / 1e-3
    for index in (0, 17, 40):
        stage.picture(index)
        # corners in the order of drawing; the indentation is computed by the kernel, from angles
        corners = (inset.artists[0].get_path().vertices[:4] @ turn)[[0, 1, 3, 2], 1]
        sides = np.array([side for _, side in CORNERS])
        # the rounding of the difference of coordinates of a metre, over 1 mm
        np.testing.assert_allclose(sides * corners - RAIL, indented[index], atol=1e-10)
    assert pytest.approx(1.0) == RAIL - HEIGHT
    index = int(np.argmax(block.forces.max(axis=1)))
    stage.picture(index)
    largest = int(np.argmax(block.forces[index]))
    tips = np.array([one.get_xy()[3] for one in inset._arrows]) @ turn
    assert np.sign(tips[largest, 1]) == CORNERS[largest][1]
    assert abs(tips[largest, 1]) == np.abs(tips[:, 1]).max() > RAIL


def test_a_block_on_a_guide_that_turns_lies_flat():
    arm = """
    joints: {O: [0, 0]}
    bars: {arm: {joints: [O, E], length: 0.3}}
    sliders: {ram: {joint: T, on: arm, mass: 0.1, inertia: 1e-5}}
    clearances:
      play: {slider: ram, size: 1 mm, length: 100 mm, height: 50 mm, contact: exact,
             restitution: 0.4, stiffness: 1e8}
    drives: {arm: {angle: 0.5, speed: 1}, ram: {position: 0.2, speed: 0}}
    """
    solution = linkages.simulate(linkages.loads(arm), end=1e-3, samples=3)
    (block,) = blocks(solution.data, solution.mechanism)
    angle = block.shapes[0].direction.angle
    assert (block.joint, angle, block.offset.shape) == ("T", 0.0, (3, 4))


def test_loads_are_as_large_as_they_are_at_the_time():
    mechanism = linkages.loads(PUSHED)
    outputs = ["joint_position", "bar_angle", "load_force", "load_torque", "joint_reaction"]
    solution = linkages.simulate(mechanism, outputs=outputs)
    pushes = [*loads(solution.data, solution.system), *reactions(solution.data, ["O"])]
    stage = Stage(solution.data, mechanism, film_of(1.0, slow=1, fps=10), dpi=60.0, pushes=pushes)
    pull, turning, torque, reaction = pushes
    drawn = stage._pushes
    # the film ends before t = 1 s; there the load is 50 N/s · 0.9 s, the reaction larger
    largest = max(float(p.sizes[:10].max()) for p in (turning, pull, reaction))
    assert drawn.forces.full == pytest.approx(largest)
    assert drawn.torques.full == pytest.approx(2 + 8 * 0.9)
    for index in (1, 4, 9):
        stage.picture(index)
        pose = stage._moving.at(index).scaled(stage._factor)
        time = 0.1 * index
        way = drawn._arrows[0].get_xy()[3] - pose.positions["A"]
        length = drawn.forces.length(50 * time)
        np.testing.assert_allclose(way / drawn._point, LONGEST * length * np.array([0.6, 0.8]))
        across = np.pi * time + np.pi / 2  # of the crank, with which the second force turns
        way = drawn._arrows[1].get_xy()[3] - pose.positions["A"]
        np.testing.assert_allclose(
            way / np.hypot(*way), [np.cos(across), np.sin(across)], atol=1e-9
        )
        assert torque.values[index] == pytest.approx(-2 - 8 * time)
    # nothing moves with the crank but what its bearing and its drive hold: both forces at A
    np.testing.assert_allclose(reaction.sizes[0], 5.0)


def test_scales_are_told_and_no_force_is_a_blob():
    even, wide = ArrowScale.of([[100.0, -250.0]]), ArrowScale.of([[0.0, 1e-2, 1.0, 100.0]])
    assert (even.root, even.full, even.key, even.length(-125.0)) == (False, 250.0, 200.0, -0.5)
    assert (wide.root, wide.length(25.0), wide.length(1e-2)) == (True, 0.5, SHORTEST)
    assert wide.length(0.0) == wide.length(np.nan) == ArrowScale.of([]).length(1.0) == 0.0
    assert ArrowScale.of([[0.0]], "N·m").full == 0.0
    assert even.text(-1234.0) == "−1.23 kN"


@pytest.mark.parametrize("length", [2.0, -2.0, 0.1])
def test_an_arrow_ends_at_its_tip(length):
    corners = arrow(np.array([0.6, 0.8]), length, 0.5, 0.05)
    np.testing.assert_allclose(corners[3], [0.6 * length, 0.8 * length])
    bent = ring(10.0, length, 5.0, 1.0)
    tip = bent[26]
    np.testing.assert_allclose(tip, [10 * np.cos((np.pi + length) / 2),
                                     10 * np.sin((np.pi + length) / 2)])  # fmt: skip


def test_a_bare_film_shows_the_mechanism_and_nothing_else():
    solution = linkages.simulate(linkages.loads(PLAY), outputs="all", samples=5)
    film = film_of(0.02)
    full, bare = (
        Stage(solution.data, solution.mechanism, film, dpi=60.0, bare=bare)
        for bare in (False, True)
    )
    for stage in (full, bare):
        stage.picture(2)
    rows, columns = bare._cut
    assert 0.6 < bare.size[0] * bare.size[1] / (full.size[0] * full.size[1]) < 0.95
    assert not any(text.get_visible() for text in bare._canvas.figure.findobj(Text))
    # whatever it shows in dark is in the full picture as well, at the same place; half a pixel of
    # an edge may lie over the grid there, which is 25 of 255 from white
    ours = bare.picture(2)[20:-20, 20:-20].astype(int)
    theirs = np.asarray(full._canvas.buffer_rgba())[rows, columns][: bare.size[1], : bare.size[0]]
    dark = ours[..., :3].max(axis=2) < 120
    assert dark.sum() > 500
    np.testing.assert_allclose(ours[dark], theirs[20:-20, 20:-20][dark], atol=25)


@pytest.mark.slow
def test_films_say_where_they_come_from(tmp_path):
    solution = linkages.simulate(linkages.load("four-bar"), samples=5)
    for name in ("a.gif", "a.webp"):
        animate(solution, tmp_path / name, fps=2, dpi=30)
        assert "coupler" in stamped(tmp_path / name).definition
        with Image.open(tmp_path / name) as image:
            assert image.n_frames > 2


def test_a_joint_without_a_reaction(tmp_path):
    solution = linkages.simulate(linkages.load("four-bar"), samples=5)
    with pytest.raises(ValueError, match="no joint 'X'; expected one of: "):
        animate(solution, tmp_path / "a.gif", reactions=["X"])
    assert not list(tmp_path.iterdir())
