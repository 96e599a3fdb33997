"""Random mechanisms with blocks in guides of ground and bars, against absolute coordinates."""

import numpy as np
import pytest
from absolute_blocks import AbsoluteBlocks
from absolute_legs import motion
from random_blocks import definition, kind

import linkages

LIMIT = 1e-8
"""In parts of the largest value; both integrate at 1e-12, and touches amplify what they differ by.
Most differ by some 1e-11."""
RTOL = 1e-12
TIMES = np.linspace(0.0, 0.012, 6)
SEEDS = range(15)


def check(seed):
    text = definition(seed)
    model = AbsoluteBlocks(text)
    own = motion(model, TIMES[1:], rtol=RTOL)
    assert any(event.kind == "touch" for event in own.events), text
    corners = range(len(model.gaps))
    walls = [[model.wall(y, k) for k in corners] for y in own.states]
    expected = {
        "clearance_indentation": [[w.rho - model.gaps[k].size for k, w in enumerate(row)]
                                  for row in walls],
        "clearance_indentation_rate": [[wall.speed for wall in row] for row in walls],
        "clearance_slip": [[wall.slip for wall in row] for row in walls],
        "clearance_force": [[model.force(k, wall, own.modes[i][k]) for k, wall in enumerate(row)]
                            for i, row in enumerate(walls)],
    }  # fmt: skip
    data = linkages.simulate(
        linkages.loads(text), times=TIMES, rtol=RTOL, outputs=[*expected]
    ).data.isel(time=slice(1, None))
    for name, values in expected.items():
        assert list(data.clearance.values) == [gap.name for gap in model.gaps]
        off = np.abs(data[name].to_numpy() - values).max()
        assert off <= LIMIT * np.abs(values).max(), (name, off, text)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_against_absolute_coordinates(seed):
    check(seed)


def test_seeds_draw_everything():
    texts = "".join(definition(seed) for seed in SEEDS)
    assert {kind(seed) for seed in SEEDS} == {"crank", "inverted", "trammel"}
    for word in ("friction", "gravity", "force"):
        assert word in texts
    assert sum(f"contact: {law}\n" in texts for law in ("hertz", "kelvin-voigt", "exact")) >= 2
