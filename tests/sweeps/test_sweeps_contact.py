"""Sweeps of mechanisms whose clearances open: modes change between samples."""

import numpy as np
import pytest
from shared_definitions import worn_engine

import linkages

WORN = worn_engine("""\
clearances:
  gap: {joint: A, bar: rod, size: 0.1 mm,
        contact: hunt-crossley-constant, stiffness: 2e8 N/m^1.5, dissipation: 1.5 s/m}
drives: {crank: {angle: 0, speed: 600 rpm}}
simulate: {end: 0.05, samples: 1001, rtol: 1e-8}
""")


def test_points_with_contact_are_single_runs():
    """In all bits; and the peak is that of samples which are fifty times as close."""
    mechanism, sizes = linkages.loads(WORN), ["0.2 mm", "0.3 mm"]
    path, measures = "clearances.gap.size", ["max(gap.force)", "mean(gap.force)"]
    data = linkages.sweep(mechanism, {path: sizes}, measures)
    assert not data.outcome.any()
    for place, size in enumerate(sizes):
        solution = linkages.simulate(mechanism.with_values({path: size}))
        alone = [linkages.measure(solution, measure) for measure in measures]
        assert [data[measure].to_numpy()[place] for measure in measures] == alone
        dense = linkages.simulate(mechanism.with_values({path: size}), samples=50001)
        largest = float(dense.data.clearance_force.max())
        # a peak exceeds the closest of its samples by (a millionth of a second times ω)²/8; the
        # rest is the interpolation over 4 samples a step, at rtol 1e-8
        assert abs(alone[0] / largest - 1) < 1e-7


def test_touches_and_losses_are_measures():
    """A touch is an event as well; what the contact loses does not come back."""
    mechanism, sizes = linkages.loads(WORN), ["0.2 mm", "0.3 mm"]
    path, lost = "clearances.gap.size", "gap.normal_dissipation"
    measures = ["final(gap.touches)", "mean(gap.touches)", f"final({lost})", f"range({lost})"]
    data = linkages.sweep(mechanism, {path: sizes}, measures)
    assert not data.outcome.any()
    for place, size in enumerate(sizes):
        single = mechanism.with_values({path: size})
        solution = linkages.simulate(
            single, outputs=["touches", "clearance_normal_dissipation"], events={"gap.touch": "up"}
        )
        alone = [linkages.measure(solution, measure) for measure in measures]
        assert [data[measure].to_numpy()[place] for measure in measures] == alone
        times = solution.events["gap.touch"].time.to_numpy()
        counts = (times <= solution.data.time.to_numpy()[:, None]).sum(axis=1)
        end = float(solution.data.time[-1])
        assert counts[-1] > 1
        assert (solution.data.touches.sel(touch="gap") == counts).all()
        assert alone[0] == counts[-1]
        assert alone[1] == pytest.approx(np.sum(end - times) / end, rel=1e-9)
        assert alone[2] == alone[3] > 0.0
