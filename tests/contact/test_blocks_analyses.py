"""What asks about motions takes blocks in guides as it takes pins: methods, sweeps, sections."""

import numpy as np
import pytest
from test_blocks import ENGINE

import linkages
from linkages.kernel.system import System
from linkages.kernel.varying import Varying

FOLLOWING = {
    "clearances.play.contact": "hunt-crossley-constant",
    "clearances.play.dissipation": 1.0,
    "clearances.play.restitution": None,
}
"""Without memory: all motions of a plan have one state."""


@pytest.fixture(scope="module")
def engine():
    return linkages.loads(ENGINE).with_values(FOLLOWING)


def offset(mechanism, **options):
    return linkages.simulate(
        mechanism, end=0.02, samples=11, outputs=["offset_position"], **options
    ).data.offset_position.to_numpy()


@pytest.mark.parametrize("method", ["vern9", "tsit5"])
def test_methods_agree(engine, method):
    """Both at 1e-12; they find the same touches."""
    expected = offset(engine, rtol=1e-12)
    np.testing.assert_allclose(offset(engine, method=method, rtol=1e-12), expected, atol=1e-12)


def test_order_of_bars_does_not_matter(engine):
    content = engine.definition.content
    reversed_bars = linkages.loads(ENGINE).with_values(
        {**FOLLOWING, "bars": dict(reversed(content["bars"].items()))}
    )
    np.testing.assert_allclose(offset(reversed_bars), offset(engine), atol=1e-12)


def test_sweep_over_numbers_of_the_block_has_one_plan(engine):
    """They are arguments of the kernel; a block that starts in a wall presses at once."""
    paths = ("clearances.play.size", "clearances.play.length", "sliders.piston.inertia")
    pressed = engine.with_values({"clearances.play.angle": "1.2 deg"})
    varying, places = Varying(pressed), set()
    for values in ((9e-4, 0.1, 3e-6), (1e-3, 0.12, 2e-6)):
        numbers = dict(zip(paths, values, strict=True))
        found, given = varying.at(numbers), System(pressed.with_values(numbers))
        expected = given.evaluate(given.model.free_accelerations)
        assert np.abs(expected[-1]) > 1e4  # rad/s²
        np.testing.assert_array_equal(found.evaluate(found.model.free_accelerations), expected)
        places.add(id(found.model))
    assert len(places) == 1


def test_section_has_offset_and_angle_of_the_block(engine):
    data = linkages.poincare(engine, periods=12)
    assert list(data.offset.values) == ["play.offset"]
    assert list(data.tilt.values) == ["play.tilt"]
    assert np.isfinite(data.tilt_angle).all()


def test_figures_of_blocks(engine):
    """One picture for the block with its border, four strips named in two lines."""
    from linkages.plots.motion import clearance_orbit

    solution = linkages.simulate(engine, end=0.02, samples=201)
    orbit = clearance_orbit.orbit_figure(solution.data, engine)
    assert len(orbit.axes) == 1
    border = orbit.axes[0].lines[0].get_xydata()
    top = border[np.abs(border[:, 1]).argmax()]
    np.testing.assert_allclose(np.abs(top), [0.0, 1.0], atol=1e-12)  # mm, at no angle
    ends = np.deg2rad(np.abs(border[[0, -1], 0]))
    # both opposite corners touch: 50 mm sin φ = 1 mm + 25 mm (1 − cos φ)
    np.testing.assert_allclose(50 * np.sin(ends), 1 + 25 * (1 - np.cos(ends)), rtol=0.01)
    strips = clearance_orbit.state_figure(solution.data, engine)
    labels = [text.get_text() for text in strips.axes[0].get_yticklabels()]
    assert labels == [f"play\ncorner{k}" for k in (4, 3, 2, 1)]
