"""Texts of measures: what they mean, what they measure, and what is refused."""

import pytest

from linkages.spec.grammar import NumberError
from linkages.spec.measures import read_measure

UNITS = {"crank.effort": "N m", "B.x position": "m", "crank.angle": "rad", "load": "N", "r": "1"}


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("max(abs(crank.effort))", "N m"),
        ("time_of_max(crank.effort)", "s"),
        ("max(B.x position) - min(B.x position)", "m"),
        ("at(0.2 s, crank.angle)", "rad"),
        ("max(crank.effort)/max(load)", "m"),
        ("rms(load)**2", "kg^2 m^2/s^4"),
        ("sqrt(mean(load*load))", "N"),
        ("max(crank.effort)/mean(crank.effort)", ""),
        ("2*max(load) - 3", "N"),
        ("max(max(load), min(load))", "N"),
        ("max(load - mean(load))", "N"),
        ("max(r)*1 kN", "N"),
        ("where(max(load) > 5 N, 1, 0)", ""),
        ("max(sin(crank.angle))*max(load)", "N"),
        ("exp(max(load)/2 N)", ""),
        ("max(atan2(B.x position, B.x position))", ""),
        ("max(2, 3)*max(load)", "N"),
        ("'B'.x position*0 + 1", None),
    ],
)
def test_unit_follows_from_those_of_series(text, unit):
    if unit is None:
        with pytest.raises(ValueError, match="within a reduction over time"):
            read_measure(text)
        return
    assert read_measure(text).units(UNITS.__getitem__) == unit


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("max(load) + 3 mm", "a force (N) and a length (m) do not go together"),
        ("at(3 mm, load)", "a time (s) and a length (m) do not go together"),
        ("sin(max(B.x position))", "'sin' takes an angle or a pure number, found a length (m)"),
        ("max(exp(load))", "'exp' takes an angle or a pure number, found a force (N)"),
        ("atan2(max(load), max(B.x position))", "a force (N) and a length (m) do not go"),
        ("max(load, crank.effort*0 + max(load))", None),
    ],
)
def test_quantities_must_go_together(text, message):
    if message is None:
        with pytest.raises(ValueError, match="within a reduction over time"):
            read_measure(text)
        return
    with pytest.raises(NumberError) as caught:
        read_measure(text).units(UNITS.__getitem__)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("load", "a measure is a number; expected outputs within a reduction over time"),
        ("max(max(load))", "'max' expects what changes with time"),
        ("at(t, load)", "'at' expects a time first"),
        ("at(load)", "'at' takes 2 arguments, found 1"),
        ("max(load, 1, 2)", "'max' takes 1 or 2 arguments, found 3"),
        ("maxi(load)", "unknown function 'maxi'"),
        ("max(load", "expected ')' at the end"),
        ("max(load) 3", "cannot read"),
        ("max(load)/0", "division by zero"),
        ("__import__('os').x", "expected"),
    ],
)
def test_what_is_no_measure_is_refused(text, message):
    with pytest.raises(ValueError, match="measure") as caught:
        read_measure(text)
    assert message in str(caught.value)


def test_names_of_series_are_those_of_axes():
    text = "max(B.x position) + min('my bar'.speed)*final(loads[0].force)/max(kinetic_energy)"
    names = ("B.x position", "my bar.speed", "loads[0].force", "kinetic_energy")
    assert read_measure(text).series == names
