"""Many motions at once are those that each mechanism makes alone, in all bits."""

import numpy as np
import pytest

import linkages
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.run import RunOptions
from linkages.solution.many import march_many
from linkages.solution.march import March
from linkages.solution.motion import Motion, Renormalised
from linkages.solvers import arrays
from linkages.solvers.loops.memory import Stepper

TIMES = np.linspace(0.02, 0.4, 5)


def varied(name, path, values):
    """Systems with some values along a path."""
    along = Varying(linkages.load(name)).along([{path: value} for value in values])
    return [along.system(index) for index in range(len(along))]


def require_equal(many, alone):
    """Whether two motions are equal in everything but the time that they took."""
    assert isinstance(many, Motion)
    assert (many.failure, many.stop_time, many.cost) == (alone.failure, alone.stop_time, alone.cost)
    assert len(many.pieces) == len(alone.pieces)
    for one, other in zip(many.pieces, alone.pieces, strict=True):
        for name in ("time", "state", "turns", "acceleration"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name


@pytest.mark.slow_except("*dop853")
@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5"])
@pytest.mark.parametrize(
    ("name", "path", "values"),
    [
        ("ninebar", "clearances.r1.size", np.linspace(1e-4, 4e-4, 3)),
        ("double-pendulum", "free.upper.angle", np.linspace(0.5, 2.5, 3)),
    ],
)
def test_motions_with_tangents_equal_those_that_go_alone(name, path, values, method):
    systems, run = varied(name, path, values), RunOptions(method=method, rtol=1e-8)
    marches, grown = ([March(s, run, tangents=1) for s in systems] for _ in range(2))
    several = [[Renormalised(), Renormalised()] for _ in systems]
    many = march_many(marches, TIMES, renormalised=[r[0] for r in several])
    for found, march, (one, other) in zip(many, grown, several, strict=True):
        require_equal(found, march.advance(TIMES, renormalised=other))
        assert np.array_equal(one.lengths, other.lengths)
        assert np.array_equal(one.tangents, other.tangents)


@pytest.mark.parametrize("tangents", [1, 2])
def test_tangents_that_fade_are_seen_in_time(tangents, monkeypatch):
    """As where every step is looked at: tangents shrink far from one sample to the next."""
    system = System(
        linkages.load("pendulum", set={"dampers": "[{joint: O, damping: 3 N m s/rad}]"})
    )
    run, found, stepper = RunOptions(rtol=1e-8), [], arrays.stepper

    def always(jobs):
        made = stepper(jobs)
        made[:, Stepper.force_scalar] = 1.0
        return made

    for watched in (False, True):
        if watched:
            monkeypatch.setattr(arrays, "stepper", always)
        renormalised = Renormalised(orthogonal=False)
        march = March(system, run, tangents=tangents)
        march.advance(np.array([20.0, 40.0]), renormalised=renormalised)
        found.append(renormalised.lengths)
    assert found[0].min() < -20.0
    assert np.array_equal(*found)


@pytest.mark.slow_except("pendulum-2")
@pytest.mark.parametrize(("name", "directions"), [("slider-crank", 0), ("pendulum", 2)])
def test_there_are_no_more_tangents_than_directions(name, directions):
    system = System(linkages.load(name))
    March(system, RunOptions(), tangents=directions)
    message = f"are {directions}; expected at most as many tangents, found {directions + 1}"
    with pytest.raises(ValueError, match=message):
        March(system, RunOptions(), tangents=directions + 1)
