import pytest
from component_reading import complaints, component, mechanism

from linkages.components.scene import SimulationDefaults

CRANK = "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 0.3}}\n"


def test_same_from_yaml_and_python():
    text = CRANK + "simulate: {end: 200 ms, samples: 2001, method: rk4, step: 1e-5, rtol: 1e-8}\n"
    made = SimulationDefaults(end=0.2, samples=2001, method="rk4", step=1e-5, rtol=1e-8)
    assert component(text, "simulate") == made


def test_defaults_with_and_without_the_section():
    assert mechanism(CRANK).simulation == SimulationDefaults()
    assert mechanism(CRANK + "simulate: {}\n").simulation == SimulationDefaults()
    defaults = SimulationDefaults()
    assert (defaults.end, defaults.samples, defaults.method) == (1.0, 1001, "dop853")
    assert (defaults.rtol, defaults.atol, defaults.step) == (1e-10, None, None)


def test_contributes_nothing_to_the_mechanism():
    assert SimulationDefaults().terms() == ()


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("end: 0", "simulate.end: expected a time > 0"),
        ("samples: 2.5", "simulate.samples: expected a whole number > 0"),
        ("rtol: -1", "simulate.rtol: expected a number > 0"),
        ("metod: rk4", "simulate.metod: unknown key 'metod'; did you mean 'method'?"),
    ],
)
def test_wrong_entries(entry, message):
    (problem,) = complaints(CRANK + f"simulate:\n  {entry}\n")
    assert problem.startswith(f"line 4, column 3, {message}")
