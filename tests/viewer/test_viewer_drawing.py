"""The drawing of a motion that a page computes, against one that is drawn for the other numbers."""

import numpy as np
import pytest
from browser import needs_browser
from test_viewer_live import change, number

import linkages
from linkages.kernel.system import System
from linkages.plots.films.stage import framed
from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.placing import placed
from linkages.plots.mechanism.shapes import Word, anchors_of
from linkages.viewer.recorded import LOAD, pivots_above, wanted

pytestmark = [needs_browser, pytest.mark.slow]

# a guide on the ground, slots on bodies that turn, a plate, a spring to a wall, a stop, a load
SCENES = {
    "slanted": """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm}
  rod: {points: {A: [0, 0], B: [140 mm, 10 mm], W: [60 mm, 50 mm]}, mass: 1, center: [0, 0],
        inertia: 1}
sliders: {piston: {joint: B, through: [0, 10 mm], angle: 20 deg, mass: 1}}
springs: [{slider: piston, stiffness: 10, position: 0}]
stops: [{slider: piston, lower: 50 mm, stiffness: 1}]
loads: [{slider: piston, force: -8}]
drives: {crank: {angle: 20 deg, speed: 6}}
assembly: {B: [180 mm, 30 mm]}
simulate: {end: 1, samples: 101}
""",
    "quick-return": "quick-return",
    "scotch-yoke": "scotch-yoke",
}
CHANGED = [
    ("slanted", "sliders.piston.angle", 1.04),
    ("slanted", "sliders.piston.through[1]", 2.0),
    ("slanted", "bars.rod.points.B[0]", 1.04),
    ("quick-return", "bars.crank.length", 1.04),
    ("scotch-yoke", "bars.crank.length", 1.04),
]

PLACED = """
(() => {
  const scene = v.stage.scene(0), camera = { scale: 1, place: ([x, y]) => [x, -y] };
  return CONTENT.shapes.filter((shape) => shape.kind !== "word").map((shape) => {
    const angle = scene.direction(shape.direction);
    const anchors = shape.kind === "line" ? shape.strokes.flat() : [shape.centre];
    return anchors.map((one) => scene.anchor(one, angle, camera, 1e-4));
  });
})()
"""


def drawn(data, mechanism):
    """Anchors of all shapes, with as many metres a point as on the page."""
    poses, _ = framed(data, mechanism)
    pose = poses.at(0)
    shapes = [s for s in shapes_of(pose) if s.look.role != LOAD and not isinstance(s, Word)]
    shapes = pivots_above(shapes, mechanism.ground)
    return [placed(pose, anchors_of(s), s.direction, 1e-4) for s in shapes]


@pytest.mark.parametrize(("name", "path", "factor"), CHANGED)
def test_a_live_drawing_is_that_of_the_other_numbers(browser, tmp_path, name, path, factor):
    text = SCENES[name]
    load = linkages.loads if "\n" in text else linkages.load
    page = browser.page()
    page.open(linkages.view(load(text), tmp_path / "page.html"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    value = number(page, path) * factor
    change(page, **{path: value})
    found = page.evaluate(PLACED)
    other = load(text, set={path: value})
    solution = linkages.simulate(other, outputs=wanted(System(other)), throw=False)
    expected = drawn(solution.data, other)
    size = max(np.abs(one).max() for one in expected)
    # how many teeth a hatching has depends on the size of the picture
    alike = [pair for pair in zip(found, expected, strict=True) if len(pair[0]) == len(pair[1])]
    assert len(alike) >= len(expected) - 1
    for own, wished in alike:
        # the ends of a travel are those of the samples, of which the page has more
        np.testing.assert_allclose(np.array(own) * (1, -1), wished, rtol=0, atol=3e-3 * size)
    assert page.complaints == []
