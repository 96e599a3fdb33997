"""Numbers that formulas share: in files and Python, units, sweeps, other structures, messages."""

import pytest
from component_reading import complaints, component

import linkages
from linkages.components.scene import NumberOfFormulas
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.solution.plan import Plan
from linkages.spec.formulas import Constant

CRANK = """
parameters: {drag: 3 N, pull: 10 N, omega: 4 rad/s}
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.2, mass: 1}}
free: {crank: {angle: 0.3, speed: 1}}
loads:
  - {bar: crank, torque: "pull*(0.1 m)*sin(omega*t) - drag*(0.1 m)*sign(crank.speed)"}
  - {bar: crank, torque: "-2*drag*0.02 m"}
"""
PLAIN = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.2, mass: 1}}
free: {crank: {angle: 0.3, speed: 1}}
loads:
  - {bar: crank, torque: "PULL*0.1*sin(OMEGA*t) - DRAG*0.1*sign(crank.speed)"}
  - {bar: crank, torque: "-2*DRAG*0.02"}
"""


def plain(drag=3, pull=10, omega=4):
    text = PLAIN.replace("DRAG", str(drag)).replace("PULL", str(pull))
    return linkages.loads(text.replace("OMEGA", str(omega)))


def end_of(mechanism):
    return linkages.simulate(mechanism, end=1.0, samples=3).data.bar_angle.item(-1)


def test_same_from_yaml_and_python():
    made = NumberOfFormulas(name="drag", value=Constant(3.0))
    assert component(CRANK.replace("3 N", "3"), "parameters", "drag") == made
    mechanism = linkages.loads(CRANK)
    assert linkages.loads(mechanism.to_yaml()) == mechanism
    assert "drag: 3 N" in mechanism.to_yaml()


def test_formulas_mean_what_numbers_in_them_would():
    assert end_of(linkages.loads(CRANK)) == pytest.approx(end_of(plain()), abs=1e-12)
    changed = linkages.loads(CRANK, set={"parameters.drag": "4 N", "parameters.omega": "5 rad/s"})
    assert end_of(changed) == pytest.approx(end_of(plain(drag=4, omega=5)), abs=1e-12)
    again = linkages.loads(CRANK).with_values({"parameters.pull": 12.0})
    assert end_of(again) == pytest.approx(end_of(plain(pull=12)), abs=1e-12)


def test_sweeps_vary_them_without_another_kernel():
    mechanism = linkages.loads(CRANK)
    varying = Varying(mechanism)
    along = varying.along([{"parameters.drag": drag} for drag in (1.0, 2.0, 5.0)])
    plans = set()
    for index, drag in enumerate((1.0, 2.0, 5.0)):
        system = along.system(index)
        plans.add(Plan.of(system).key)
        built = System(mechanism.with_values({"parameters.drag": drag}))
        assert system.parameters == pytest.approx(built.parameters, abs=0)
        laws = [load.law for load in system.mechanism.loads]
        assert laws == [load.law for load in built.mechanism.loads]
    assert len(plans) == 1


def test_drives_use_them():
    text = """
parameters: {turns: 3, lead: 20 deg}
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.2}}
drives: {crank: {law: "lead + turns*t"}}
"""
    data = linkages.simulate(linkages.loads(text.replace("20 deg", "0.5")), end=2.0, samples=3).data
    assert data.bar_angle.to_numpy()[:, 0] == pytest.approx([0.5, 3.5, 6.5])
    assert data.bar_speed.to_numpy()[:, 0] == pytest.approx([3.0, 3.0, 3.0])


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("pull*(0.1", "pul*(0.1", "unknown name 'pul'; did you mean 'pull'? (character 1"),
        ("pull*(0.1", "force*(0.1", "unknown name 'force'; expected t, pi, drag, pull, omega, or"),
        ("pull: 10 N", "pull: 10 m", "do not go together"),
        ("2*drag*0.02 m", "2*drag", "it is a force (N), not a torque"),
        ("pull: 10 N", "t: 3", "parameters.t: 't' means something else in formulas"),
        ("pull: 10 N", "in-put: 3", "expected a word of letters, digits and _"),
        ("pull: 10 N", "pull: much", "expected a number (in SI, or with a unit)"),
    ],
)
def test_wrong_entries(old, new, found):
    problems = complaints(CRANK.replace(old, new))
    assert any(found in problem for problem in problems), problems
