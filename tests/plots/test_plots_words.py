"""Series and measures in the words of figures."""

import pytest

import linkages
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.plots.style import measure_words, series_words
from linkages.solution.series import system_series


@pytest.mark.parametrize(
    ("name", "units", "words"),
    [
        ("crank.effort", "N m", "driving torque of crank"),
        ("ram.effort", "N", "driving force of ram"),
        ("rocker.angle", "rad", "angle of rocker"),
        ("P.x velocity", "m/s", "joint velocity of P, x component"),
        ("P.velocity", "m/s", "velocity of P"),
        ("r1.force", "N", "force of r1"),  # of a clearance, or of a spring
        ("loads[0].force", "N", "loads[0].force"),
        ("kinetic_energy", "J", "kinetic energy"),
        ("crank.rocker.mechanical advantage", "1", "mechanical advantage of rocker by crank"),
        ("stroke", "m", "stroke"),
        ("parameters.A", "", "parameters.A"),
    ],
)
def test_series_in_words(name, units, words):
    assert series_words(name, units) == words


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("max(abs(crank.effort))", "max(abs(driving torque of crank))"),
        ("max(ground.x_shaking_force**2)", "max(shaking force of ground, x component**2)"),
        ("min(transmission_angle) - 2*x", "min(transmission angle) - 2*x"),
    ],
)
def test_measures_in_words(text, words):
    assert measure_words(text) == words


@pytest.mark.parametrize("name", ["four-bar", "slider-crank-contact", "andrews"])
def test_every_series_of_a_mechanism_has_the_words_of_its_axis(name):
    """The long name of its output, or the word of its name where several outputs share that."""
    system = System(linkages.load(name))
    for series in system_series(system).values():
        if series.variable == "time":
            continue
        item = VARIABLES[series.variable]
        found = series_words(series.name, item.units)
        elements = [label for dim, label in series.place.items() if dim != "axis"]
        if not any("[" in element for element in elements):
            own = series.words(item.long_name)
            quantity = series.name.rpartition(".")[2].removeprefix(f"{series.place.get('axis')} ")
            assert found in (own, series.words(quantity)), series.name
