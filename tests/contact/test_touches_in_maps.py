"""Maps count touches beside their indicator; diagrams of contact are those of single motions."""

import numpy as np
import pytest

import linkages
from linkages.chaos import bifurcation
from linkages.chaos.diagram import touchable
from linkages.kernel.system import System
from linkages.solution.march import alone

SIZE, SPEED = "clearances.gap.size", "drives.crank.speed"
TURN = 0.012
PERIODS, SKIP = 4, 1


@pytest.fixture(scope="module", params=["lankarani-nikravesh", "restitution"])
def engine(request):
    found = linkages.load("slider-crank-contact")
    if request.param == "restitution":
        gap = {"joint": "B", "bar": "rod", "size": 5e-4, "contact": "restitution"}
        found = found.with_values({"clearances.gap": gap | {"restitution": 0.2}})
    return found


def test_touches_of_a_map_are_those_of_single_motions(engine):
    """Motions forget two digits a turn: over five of them 1e-13 is enough to count the same."""
    sizes, speeds = [2e-4, 3e-4], [500.0, 2 * np.pi / TURN]
    own = {"periods": PERIODS, "skip": SKIP, "rtol": 1e-13}
    data = linkages.chaos_map(engine, {SPEED: speeds}, {SIZE: sizes}, **own)
    assert data.touches.dims == ("y", "x", "touch")
    assert data.touch.to_numpy().tolist() == touchable(System(engine)) == ["gap"]
    for row, size in enumerate(sizes):
        for column, speed in enumerate(speeds):
            single = engine.with_values({SIZE: size, SPEED: speed})
            period = 2 * np.pi / speed
            exponents = linkages.lyapunov(single, count=1, **own)
            expected = float(exponents.exponent[0])
            found = data.isel(y=row, x=column)
            assert float(found.indicator) == pytest.approx(expected, rel=1e-12)
            end = (PERIODS + SKIP) * period
            motion = linkages.simulate(
                single, end=end, samples=2, rtol=1e-13, events={"gap.touch": "up"}
            )
            times = motion.events["gap.touch"].time.to_numpy()
            counted = (times > SKIP * period).sum() / PERIODS
            assert float(found.touches[0]) == pytest.approx(counted)


def test_what_cannot_touch_has_no_touches():
    values = {"bars.upper.length": [0.9, 1.0]}, {"bars.lower.length": [0.9, 1.0]}
    assert "touches" not in linkages.chaos_map(linkages.load("double-pendulum"), *values, periods=4)


@pytest.mark.parametrize("options", [{"section": "gap.touch"}, {"exponent": True}])
def test_values_of_a_diagram_side_by_side_are_those_alone(engine, options, monkeypatch):
    own = {"periods": 4, "skip": 1, **options}
    monkeypatch.setattr(bifurcation, "EXPONENT_PERIODS", 5)
    together, company = bifurcation.side_by_side, []

    def counted(tasks, watch=None):
        company.append(len(tasks))
        return together(tasks, watch)

    monkeypatch.setattr(bifurcation, "side_by_side", counted)
    values = {SIZE: np.linspace(2e-4, 5e-4, 9)}
    found = linkages.bifurcation(engine, values, **own)
    assert max(company) > 1
    monkeypatch.setattr(bifurcation, "side_by_side", lambda tasks, _: [alone(t) for t in tasks])
    assert found.identical(linkages.bifurcation(engine, values, **own))
    assert (found.outcome == 0).any()
