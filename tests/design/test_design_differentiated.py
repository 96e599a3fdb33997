"""Derivatives of measures by numbers of a definition, against closed forms and differences."""

from __future__ import annotations

import math

import numpy as np
import pytest
from design_differences import richardson

import linkages
from linkages.components.mechanisms.definition import reread
from linkages.design.differentiated import Differentiated
from linkages.errors import ComputationError, InputError
from linkages.kernel.inputs import definition_numbers
from linkages.kernel.number_effects import effects, numbers_of, value_of, written
from linkages.kernel.system import System


def test_stroke_and_speed_of_a_slider_crank_have_the_derivatives_of_their_closed_forms():
    """In line: the stroke is 2r, and at crank angle 0 the acceleration −ω²r(1 + r/l)."""
    mechanism = linkages.load("slider-crank")
    paths = ["bars.crank.length", "bars.rod.length", "drives.crank.speed"]
    found = Differentiated(
        mechanism, ["stroke(piston.position)", "at(0, piston.acceleration)"], paths
    )
    r, l, w = found.values  # noqa: E741
    evaluated = found.at(found.values)
    assert evaluated.derivatives is not None
    # round-off of positions of size l, divided by nothing
    np.testing.assert_allclose(evaluated.derivatives[0], [2.0, 0.0, 0.0], atol=1e-12)
    closed = [-(w**2) * (1 + 2 * r / l), w**2 * r**2 / l**2, -2 * w * r * (1 + r / l)]
    np.testing.assert_allclose(evaluated.derivatives[1], closed, rtol=1e-12)


def test_time_of_an_extreme_moves_as_implicit_differentiation_says():
    """A rocker's extreme comes at one angle of the crank: earlier by dφ/ω for each start angle."""
    mechanism = linkages.load("four-bar")
    found = Differentiated(mechanism, ["time_of_max(rocker.angle)"], ["drives.crank.angle"])
    speed = next(d for d in numbers_of(mechanism, ["drives.crank.speed"]))
    expected = -1.0 / value_of(mechanism, speed)
    # the conditioning of second derivatives of a polynomial of degree 24
    assert found.at(found.values).derivatives == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", ["andrews", "four-bar", "slider-crank-contact", "toggle-press"])
def test_parameters_follow_from_numbers_as_definitions_read_again_say(name):
    """Sums and products of the numbers: central differences of step 1e-4 are exact to 1e-11."""
    mechanism = linkages.load(name)
    numbers = written(mechanism)
    system = System(mechanism.keeping([number.path for number in numbers]))
    found = effects(system, numbers)
    slopes = iter(found.slopes)
    for number, fed in zip(numbers, found.fed, strict=True):
        value = value_of(mechanism, number)
        step = 1e-4 * (abs(value) or 1.0)
        ends = []
        for moved in (value + step, value - step):
            component = mechanism.components[number.component]
            where = (*component.path, *_steps(number.path, component.path))
            read = reread(mechanism, component, {where: moved})
            assert read is not None
            place = {number.component: (read, mechanism.terms_of(read))}
            ends.append(definition_numbers(mechanism.exchanging(place)))
        changes = {
            path: (ends[0][path] - ends[1][path]) / (2 * step)
            for path in ends[0].keys() & ends[1].keys()
            if ends[0][path] != ends[1][path] and path != ("nearest",)
        }
        own = dict(zip(fed, [next(slopes) for _ in fed], strict=True))
        assert changes.keys() <= own.keys()
        for path, slope in own.items():
            assert slope == pytest.approx(changes.get(path, 0.0), rel=1e-7, abs=1e-9)


def _steps(path: str, component: tuple[str | int, ...]) -> tuple[str | int, ...]:
    from linkages.reading.paths import split

    return (split(path) or ())[len(component) :]


def test_a_mechanism_that_cannot_be_assembled_is_refused_with_the_reason():
    mechanism = linkages.load("four-bar")
    found = Differentiated(mechanism, ["max(rocker.angle)"], ["bars.rocker.length"])
    with pytest.raises((InputError, ComputationError), match="rocker"):
        found.at(np.array([1e-3]))


def test_paths_that_lead_to_no_number_are_listed_with_the_nearest_one():
    with pytest.raises(InputError) as refusal:
        Differentiated(
            linkages.load("four-bar"),
            ["max(rocker.angle)"],
            ["bars.rocker.lenght", "assembly.B", "wheels.*"],
        )
    text = str(refusal.value)
    assert "did you mean 'bars.rocker.length'?" in text
    assert "assembly.B: found no number there" in text
    assert "fits this pattern" in text


def test_a_number_that_is_zero_stays_and_has_a_derivative():
    """Gravity across a balanced direction: the mean effort of a full turn does not change."""
    mechanism = linkages.load("four-bar")
    found = Differentiated(
        mechanism, ["max(crank.effort)"], ["joints.O2[1]"], run={"samples": 201}
    ).at(np.zeros(1))
    assert found.derivatives is not None
    assert math.isfinite(found.derivatives[0, 0])
    assert found.derivatives[0, 0] != 0.0


@pytest.mark.slow
def test_an_extreme_at_a_corner_moves_with_the_corner():
    """Where rising and falling branches meet, x(t*) = c(t*): dm/dp by Richardson's differences."""
    mechanism = linkages.load("slider-crank")
    corner = "min(piston.position, 0.1 m + t*1 m/s + 0.03 m*sin(t*100 rad/s))"
    measures = [f"max({corner})", "min(abs(piston.velocity))", f"time_of_max({corner})"]
    found = Differentiated(
        mechanism, measures, ["bars.crank.length", "bars.rod.length"],
        run={"end": 0.03, "samples": 301},
    )  # fmt: skip
    exact = found.at(found.values).derivatives
    assert exact is not None
    for number in range(2):
        difference, error = richardson(
            lambda x: found.at(x, derivatives=False).values, found.values, number, 1e-4
        )
        # a corner is located to 1e-10 samples; steps are 1e-6 to 1e-4 m
        assert abs(exact[0, number] - difference[0]) < 1e-6 + 10 * error[0]
        assert abs(exact[2, number] - difference[2]) < 1e-6 + 10 * error[2]
    assert exact[1] == pytest.approx(0.0, abs=1e-6)  # zero stays the least size


@pytest.mark.slow
@pytest.mark.parametrize("samples", [31, 301])
def test_means_of_what_bends_or_jumps_by_itself_do_not_depend_on_samples(samples):
    """Zeros of what decides between branches are located: 31 samples a turn are enough."""
    measures = [
        "mean(abs(crank.effort))",
        "rms(max(crank.effort, 0.1 N*m))",
        "mean(sign(crank.effort))",
        "mean(where(rocker.speed > 0 rad/s, crank.effort, 2*crank.effort))",
    ]
    paths = ["bars.rocker.length", "drives.crank.speed"]
    run = {"end": 1.0, "samples": samples}
    found = Differentiated(linkages.load("four-bar"), measures, paths, run=run)
    exact = found.at(found.values).derivatives
    assert exact is not None
    for number, value in enumerate(found.values):
        difference, error = richardson(
            lambda x: found.at(x, derivatives=False).values, found.values, number, 1e-4 * value
        )
        # Gauss's rule with five places between samples that are 12° apart
        missed = np.abs(exact[:, number] - difference)
        assert (missed <= 1e-8 * np.abs(difference) + 10 * error).all()


@pytest.mark.slow_except("slider-crank-*")
@pytest.mark.parametrize("samples", [5, 60])
@pytest.mark.parametrize("name", ["slider-crank", "class-three"])
def test_means_and_their_derivatives_do_not_depend_on_samples(name, samples):
    """Drives determine the motion. Differences are of measures of the motion by itself."""
    mechanism = linkages.load(name, set={"simulate.end": "0.05 s" if name[0] == "s" else "1 s"})
    path, series = {
        "slider-crank": ("bars.rod.length", "piston.velocity"),
        "class-three": ("bars.leg2.length", "plate.speed"),
    }[name]
    measures = [f"rms({series})", f"mean(abs({series}))"]
    found = Differentiated(mechanism, measures, [path], run={"samples": samples})
    evaluated = found.at(found.values)

    def alone(numbers):
        solution = linkages.simulate(mechanism.with_values({path: float(numbers[0])}))
        return np.array([linkages.measure(solution, each) for each in measures])

    assert evaluated.values == pytest.approx(alone(found.values), rel=1e-9)
    slopes, error = richardson(alone, found.values, 0, 2e-3 * found.values[0])
    # kinks move with the number: differences are as good as these are located, some 1e-10
    assert evaluated.derivatives[:, 0] == pytest.approx(slopes, rel=1e-7, abs=float(error.max()))


@pytest.mark.parametrize("samples", [5, 26])
def test_a_load_that_jumps_with_the_position_has_exact_derivatives(samples):
    """The mean torque is the work of the cut over a turn, F·2h/2π."""
    mechanism = linkages.loads("""
        parameters: {cut: 2 kN, half: 150 mm}
        joints: {O: [0, 0]}
        bars:
          crank: {joints: [O, A], length: 200 mm, mass: 1}
          rod: {joints: [A, B], length: 700 mm, mass: 1}
        sliders: {ram: {joint: B, through: O, mass: 3}}
        assembly: {B: [900 mm, 0]}
        drives: {crank: {angle: 10 deg, speed: 60 rpm}}
        loads:
          - slider: ram
            force: where(ram.velocity < 0 m/s and abs(ram.position - 0.7 m) < half, cut, 0 N)
    """)
    paths = ["parameters.cut", "parameters.half"]
    run = {"end": 1.0, "samples": samples}
    found = Differentiated(mechanism, ["mean(crank.effort)"], paths, run=run)
    evaluated = found.at(found.values)
    assert evaluated.values == pytest.approx([300 / np.pi], rel=1e-8)
    assert evaluated.derivatives[0] == pytest.approx([0.15 / np.pi, 2000 / np.pi], rel=1e-7)


def test_a_value_at_a_time_that_follows_from_the_motion_moves_with_it():
    """y(t*) changes by ∂y/∂p + y' ∂t*/∂p."""
    mechanism = linkages.load("slider-crank")
    measures = [
        "at(time_of_max(piston.velocity), crank.angle)",
        "at(final(t)/3, piston.position)",
    ]
    paths = ["bars.rod.length", "drives.crank.speed"]
    found = Differentiated(mechanism, measures, paths)
    evaluated = found.at(found.values)

    def values(numbers):
        return found.at(numbers, derivatives=False).values

    for column, size in enumerate(found.values):
        slopes, error = richardson(values, found.values, column, 1e-3 * size)
        allowed = 1e-9 * abs(evaluated.values / size) + 10 * error
        assert (abs(evaluated.derivatives[:, column] - slopes) <= allowed).all()
