"""Numbers with a tolerance: what they state, and what is wrong with them."""

from __future__ import annotations

import pytest

import linkages
from linkages.spec.conversion import ToleranceZone, zone_of

FOUR_BAR = """\
name: Tolerances
joints: {O: [0, 0], C: [100 ± 0.1 mm, 0]}
bars:
  crank: {joints: [O, A], length: 30 +/- 0.02 mm}
  coupler: {joints: [A, B], length: 100 +0.1/-0.05 mm (uniform)}
  rocker: {joints: [B, C], length: 80 mm, mass: 0.2 kg ± 5 %}
drives: {crank: {angle: 0 ± 0.5 deg, speed: 60 rpm}}
assembly: {B: left}
parameters: {push: 3 ± 0.1 N}
loads:
- {joint: B, on: rocker, force: [push, -20 ± 2 N]}
"""
PLAIN = """\
name: Tolerances
joints: {O: [0, 0], C: [100 mm, 0]}
bars:
  crank: {joints: [O, A], length: 30 mm}
  coupler: {joints: [A, B], length: 100 mm}
  rocker: {joints: [B, C], length: 80 mm, mass: 0.2 kg}
drives: {crank: {angle: 0 deg, speed: 60 rpm}}
assembly: {B: left}
parameters: {push: 3 N}
loads:
- {joint: B, on: rocker, force: [push, -20 N]}
"""


@pytest.mark.parametrize(
    ("text", "nominal", "low", "high", "distribution", "sigmas"),
    [
        ("140 ± 0.05 mm", 0.14, -5e-5, 5e-5, "normal", 3),
        ("140 +/- 0.05 mm", 0.14, -5e-5, 5e-5, "normal", 3),
        ("140 +-0.05 mm", 0.14, -5e-5, 5e-5, "normal", 3),
        ("140 mm ± 50 um", 0.14, -5e-5, 5e-5, "normal", 3),
        ("140 mm ± 0.05", 0.14, -5e-5, 5e-5, "normal", 3),
        ("0.14 ± 5e-5", 0.14, -5e-5, 5e-5, "normal", 3),
        ("−140 ± 0.05 mm (2 sigma)", -0.14, -5e-5, 5e-5, "normal", 2),
        ("140 ± 0.05 mm (normal, 4 sigma)", 0.14, -5e-5, 5e-5, "normal", 4),
        ("140 +0.1/-0.05 mm", 0.14, -5e-5, 1e-4, "normal", 3),
        ("140 0/-0.05 mm (triangular)", 0.14, -5e-5, 0.0, "triangular", 3),
        ("20 +0.013/+0.002 mm (uniform)", 0.02, 2e-6, 1.3e-5, "uniform", 3),
        ("500 N/(m) ± 5 %", 500.0, -25.0, 25.0, "normal", 3),
        ("0 ± 0.1 mm", 0.0, -1e-4, 1e-4, "normal", 3),
        ("2*70 ± 0.05 mm", 0.14, -5e-5, 5e-5, "normal", 3),
    ],
)
def test_a_tolerance_is_read(
    text: str, nominal: float, low: float, high: float, distribution: str, sigmas: float
) -> None:
    zone = zone_of(text)
    assert zone is not None
    assert zone.nominal == nominal  # the very bits of the number without its tolerance
    # limits are sums of numbers of size one: they differ by their rounding
    assert zone.low == pytest.approx(nominal + low, rel=1e-15, abs=1e-20)
    assert zone.high == pytest.approx(nominal + high, rel=1e-15, abs=1e-20)
    assert (zone.distribution, zone.sigmas) == (distribution, sigmas)


@pytest.mark.parametrize("text", ["140 mm", "10 +-2*3", "10 +-2*sin(t)", "3/-2", "7 - 2", "A/B"])
def test_arithmetic_and_formulas_state_no_tolerance(text: str) -> None:
    assert zone_of(text) is None


def test_deviations_are_those_of_the_distributions() -> None:
    # variances of a normal, a uniform and a symmetric triangular distribution
    def of(name: str) -> float:
        return ToleranceZone(1.0, 0.7, 1.3, name, 2.0).deviation

    assert of("normal") == pytest.approx(0.15, rel=1e-15)
    assert of("uniform") == pytest.approx(0.3 / 3**0.5, rel=1e-15)
    assert of("triangular") == pytest.approx(0.3 / 6**0.5, rel=1e-15)


def test_everything_but_the_tolerances_is_as_without_them() -> None:
    toleranced, plain = linkages.loads(FOUR_BAR), linkages.loads(PLAIN)
    assert toleranced == plain
    options = {"end": 0.3, "samples": 31}
    found, wanted = (linkages.simulate(each, **options).data for each in (toleranced, plain))
    assert found.equals(wanted)  # bit for bit
    assert [*toleranced.tolerances] == [
        "joints.C[0]",
        "bars.crank.length",
        "bars.coupler.length",
        "bars.rocker.mass",
        "drives.crank.angle",
        "parameters.push",
        "loads[0].force[1]",
    ]
    assert not plain.tolerances


def test_tolerances_are_written_and_stay_where_numbers_stay() -> None:
    mechanism = linkages.loads(FOUR_BAR)
    assert linkages.loads(mechanism.to_yaml()).tolerances == mechanism.tolerances
    other = mechanism.with_values(
        {"bars.crank.length": "31 ± 0.01 mm (normal, 4 sigma)", "bars.coupler.length": 0.11}
    )
    assert other.tolerances["bars.crank.length"].sigmas == 4
    assert "bars.coupler.length" not in other.tolerances
    assert "joints.C[0]" in other.tolerances
    again = linkages.loads(other.to_yaml())
    assert again == other
    assert again.tolerances == other.tolerances


def test_numbers_that_python_leaves_alone_keep_their_tolerances() -> None:
    from dataclasses import replace

    mechanism = linkages.loads(FOUR_BAR)
    changed = tuple(
        replace(part, mass=0.3) if getattr(part, "name", "") == "crank" and part.section == "bars"
        else part for part in mechanism.components
    )  # fmt: skip
    other = replace(mechanism, components=changed)
    assert other.tolerances == mechanism.tolerances


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[O, A]", "[O, A ± 1]", "bars.crank.joints[1]: expected a name"),
        ("30 +/- 0.02 mm", "30 ± -0.02 mm", "a tolerance is larger than 0"),
        ("30 +/- 0.02 mm", "30 ± 0 mm", "a tolerance is larger than 0"),
        ("30 +/- 0.02 mm", "30 mm ± 0.02 kg", "'0.02 kg': kg is a mass, not a length"),
        ("30 +/- 0.02 mm", "30 ± 40 mm", "its tolerance reaches down to -0.01 m"),
        ("30 +/- 0.02 mm", "30 ± small mm", "such as ± 0.05 mm or +0.1/-0.05 mm"),
        ("30 +/- 0.02 mm", "30 ± 0.02 mm (unifrom)", "did you mean 'uniform'?"),
        ("30 +/- 0.02 mm", "30 ± 0.02 mm (uniform 3 sigma)", "go with a normal distribution"),
        ("push: 3 ± 0.1 N", "push: 3 ± 0 N", "a tolerance is larger than 0"),
        ("-20 ± 2 N", "-20*t ± 2 N", "expected a force"),
        ("{B: left}", "{B: left}\nsimulate: {end: 1 ± 0.1 s}", "options have no tolerance"),
        ("{B: left}", "{B: left}\nsimulate: {samples: 9 ± 1}", "have no tolerance"),
    ],
)
def test_bad_tolerances_are_refused(old: str, new: str, message: str) -> None:
    with pytest.raises(linkages.InputError) as caught:
        linkages.loads(FOUR_BAR.replace(old, new))
    assert message in str(caught.value)
    assert "line " in str(caught.value)
