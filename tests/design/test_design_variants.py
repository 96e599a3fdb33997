"""Searches over assembly branches and senses of rotation, and fits under constraints."""

import numpy as np
import pytest

import linkages
from linkages.design.variants import variants_of

FOUR_BAR = linkages.load("four-bar")
OTHER = {"assembly.B": "right", "drives.crank.speed": "-60 rpm"}
PATH = ("P.x position", "P.y position")


def points_of(mechanism, count=12, end=0.9):
    data = linkages.simulate(mechanism, end=end, samples=count, outputs=["joint_position"]).data
    x, y = data.joint_position.sel(joint="P").to_numpy().T
    return {"time (s)": data.time.to_numpy(), f"{PATH[0]} (m)": x, f"{PATH[1]} (m)": y}


def test_variants_are_branches_times_senses():
    found = variants_of(FOUR_BAR, "all")
    assert [one.name for one in found] == [
        "B left, crank as in the file", "B left, crank reversed",
        "B right, crank as in the file", "B right, crank reversed",
    ]  # fmt: skip
    assert found[-1].values == OTHER
    assert variants_of(FOUR_BAR, "file")[0].values == {}
    kept = variants_of(FOUR_BAR, "all", ["drives.crank.speed"])
    assert [one.name for one in kept] == ["B left", "B right"]


@pytest.mark.parametrize("name", ["class-three", "slider-crank", "ninebar-ideal", "watt-six-bar"])
def test_every_variant_can_be_assembled_and_differs(name):
    mechanism = linkages.load(name)
    starts = []
    for variant in variants_of(mechanism, "all"):
        own = mechanism.with_values(variant.values)
        data = linkages.simulate(own, end=1e-3, samples=2, outputs=["joint_position"], throw=False)
        starts.append(np.array(data.data.joint_position).ravel())
    apart = [np.abs(a - b).max() for k, a in enumerate(starts) for b in starts[:k]]
    assert min(apart) > 1e-9


def test_an_unknown_choice_is_refused():
    with pytest.raises(ValueError, match="unknown branches 'al'; did you mean 'all'"):
        linkages.optimise(
            FOUR_BAR, ["bars.rocker.length=70mm:90mm"], minimise="max(t)", branches="al"
        )


def test_a_fit_finds_the_branch_and_the_sense_of_what_was_measured():
    lengths = {"bars.coupler.points.P[0]": "55 mm", "bars.coupler.points.P[1]": "42 mm"}
    measured = points_of(FOUR_BAR.with_values(OTHER | lengths))
    vary = ["bars.coupler.points.P[0]=30:70mm", "bars.coupler.points.P[1]=30:60mm"]
    own = linkages.fit(FOUR_BAR, measured, vary)
    assert own.data.attrs["chi_square"] > 1e-3
    assert any("keeps the assembly mode" in note for note in own.data.attrs["notes"])
    found = linkages.fit(FOUR_BAR, measured, vary, branches="all")
    assert found.data.attrs["variant"] == "B right, crank reversed"
    assert found.data.attrs["chi_square"] < 1e-20
    assert float(found.data["variant_squares"][0]) == own.data.attrs["chi_square"]
    assert next(iter(found.variants)) == "B right, crank reversed"
    np.testing.assert_allclose(found.data["number"].sel(state="fit"), [0.055, 0.042], rtol=1e-9)
    assert "#   B right, crank reversed\n" in found.text
    again = linkages.loads(found.text)
    np.testing.assert_allclose(points_of(again)[f"{PATH[1]} (m)"], measured[f"{PATH[1]} (m)"])


def test_an_optimum_is_sought_in_all_branches():
    height = float(points_of(FOUR_BAR.with_values(OTHER))[f"{PATH[1]} (m)"][0])
    asked = {"minimise": f"(at(0 s, P.y position) - {height!r} m)**2"}
    vary = ["bars.rocker.length=79mm:81mm"]
    own = linkages.optimise(FOUR_BAR, vary, **asked)
    found = linkages.optimise(FOUR_BAR, vary, branches="all", **asked)
    assert float(own.data["value"][1]) > 1e-3
    assert float(found.data["value"][1]) < 1e-20
    assert found.data.attrs["variant"].startswith("B right")
    assert found.data.attrs["runs"] > own.data.attrs["runs"]
    assert float(found.data["variant_value"][0]) == float(own.data["value"][1])


def test_a_constraint_of_a_fit_holds_where_it_is_met():
    """The range of the rocker falls with its length: it is met where it is that of 85 mm."""
    measured = points_of(FOUR_BAR)
    limit = linkages.measure(
        linkages.simulate(FOUR_BAR.with_values({"bars.rocker.length": "85 mm"})),
        "range(rocker.angle)",
    )
    found = linkages.fit(
        FOUR_BAR, measured, ["bars.rocker.length=75mm:95mm"], end=1.0,
        subject_to=f"range(rocker.angle) < {limit!r} rad",
    )  # fmt: skip
    assert float(found.data["number"].sel(state="fit").item()) == pytest.approx(0.085, abs=1e-8)
    assert any("nothing to spare" in note for note in found.data.attrs["notes"])
    free = linkages.fit(
        FOUR_BAR, measured, ["bars.rocker.length=75mm:95mm"], subject_to="range(rocker.angle) < 9"
    )
    assert float(free.data["number"].sel(state="fit").item()) == pytest.approx(0.08, abs=1e-9)


def test_constraints_that_nothing_satisfies_are_named():
    with pytest.raises(linkages.ComputationError, match=r"satisfies range\(rocker.angle\) < 0.1"):
        linkages.fit(
            FOUR_BAR, points_of(FOUR_BAR), ["bars.rocker.length=75mm:85mm"],
            subject_to="range(rocker.angle) < 0.1",
        )  # fmt: skip


def test_a_constraint_without_a_value_is_not_satisfied():
    """Nothing may pass as if 1/0 were below a limit."""
    with pytest.raises(linkages.ComputationError, match=r"no feasible start: .*no finite value"):
        linkages.fit(
            FOUR_BAR, points_of(FOUR_BAR), ["bars.rocker.length=75mm:85mm"],
            subject_to="max(1/(crank.angle - crank.angle)) < 5",
        )  # fmt: skip


EIGHTEEN = """
name: Path generator
joints: {O2: [0.2, 0], O4: [1.0, 0.2]}
bars:
  crank: {joints: [O2, A], length: 0.4}
  coupler: {points: {A: [0, 0], B: [0.9, 0], P: [0.5, 0.4]}}
  rocker: {joints: [O4, B], length: 0.8}
drives: {crank: {angle: 60 deg, speed: 20 deg/s}}
assembly: {B: left}
simulate: {end: 17, samples: 18}
"""
POINTS = [
    (0.5, 1.1), (0.4, 1.1), (0.3, 1.1), (0.2, 1.0), (0.1, 0.9), (0.05, 0.75), (0.02, 0.6),
    (0, 0.5), (0, 0.4), (0.03, 0.3), (0.1, 0.25), (0.15, 0.2), (0.2, 0.3), (0.3, 0.4),
    (0.4, 0.5), (0.5, 0.7), (0.6, 0.9), (0.6, 1.0),
]  # fmt: skip
"""A. Kunjur and S. Krishnamurty, "Genetic algorithms in mechanism synthesis" (1995)."""


@pytest.mark.slow
def test_eighteen_points_with_timing_reach_the_best_known_sum_of_squares():
    """0.00902888463 by SciPy's least squares on closed-form kinematics, from 30 starts a branch."""
    x, y = np.array(POINTS).T
    measured = {"time (s)": np.arange(18.0), "P.x position (m)": x, "P.y position (m)": y}
    vary = [
        *(f"joints.{joint}[{axis}]=-1:2" for joint in ("O2", "O4") for axis in (0, 1)),
        "bars.crank.length=0.05:1", "bars.coupler.points.B[0]=0.1:2", "bars.rocker.length=0.1:2",
        *(f"bars.coupler.points.P[{axis}]=-2:2" for axis in (0, 1)),
        "drives.crank.angle=0:360deg",
    ]  # fmt: skip
    found = linkages.fit(linkages.loads(EIGHTEEN), measured, vary, branches="all", starts=6, seed=1)
    assert found.data.attrs["chi_square"] == pytest.approx(0.00902888463, rel=1e-8)
    cognates = np.sort(found.data["variant_squares"].to_numpy())[:2]
    assert cognates[0] == pytest.approx(cognates[1], rel=1e-6)
