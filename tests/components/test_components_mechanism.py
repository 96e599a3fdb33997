import pytest
from component_reading import mechanism

from linkages.components.actuators import Drive
from linkages.components.contributed.component import Component
from linkages.components.contributed.load_measures import Slide, Turn
from linkages.components.external_loads import SliderForce
from linkages.components.joint_clearances import Clearance
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.rigid_bodies import Bar, GroundJoint, Slider
from linkages.components.scene import AssemblyHint, FreeAngle, SimulationDefaults, UniformGravity
from linkages.components.springs import ClearanceDamper
from linkages.errors import InputError

TEXT = """
name: Slider-crank
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.25, mass: 1}
  rod: {joints: [A, B], length: 0.8}
sliders:
  piston: {joint: B, through: O, mass: 3}
clearances:
  r1: {joint: A, bar: rod, size: 1e-4}
drives:
  crank: {angle: 0.7, speed: 10}
assembly:
  B: [1, 0]
loads:
  - {slider: piston, force: -40}
simulate: {end: 2}
"""
# in the order of the sections in the registry
COMPONENTS = (
    UniformGravity(acceleration=(0, -9.81)),
    GroundJoint(name="O", position=(0, 0)),
    Bar(name="crank", joints=("O", "A"), length=0.25, mass=1),
    Bar(name="rod", joints=("A", "B"), length=0.8),
    Slider(name="piston", joint="B", through="O", mass=3),
    Clearance(name="r1", joint="A", bar="rod", size=1e-4),
    Drive(name="crank", angle=0.7, speed=10),
    AssemblyHint(name="B", where=(1, 0)),
    SliderForce(index=0, slider="piston", force=-40),
    SimulationDefaults(end=2),
)


@pytest.fixture
def slider_crank():
    return Mechanism(components=COMPONENTS, name="Slider-crank")


def test_from_yaml_equals_built_in_python(slider_crank):
    read = mechanism(TEXT)
    assert read.components == slider_crank.components
    assert read.terms == slider_crank.terms
    assert read.bodies == slider_crank.bodies
    assert read.name == slider_crank.name
    assert (read.source, slider_crank.source) == ("m.yaml", "mechanism")


def test_frozen_and_keyword_only(slider_crank):
    with pytest.raises(AttributeError):
        slider_crank.name = "other"
    with pytest.raises(TypeError):
        Mechanism(COMPONENTS)


def test_any_iterable_of_components(slider_crank):
    assert Mechanism(components=iter(COMPONENTS), name="Slider-crank") == slider_crank


def test_terms_by_kind(slider_crank):
    assert [*slider_crank.ground] == ["O"]
    assert [*slider_crank.prescribed] == ["crank"]
    assert [*slider_crank.initial] == ["r1"]
    assert [*slider_crank.hints] == ["B"]
    assert [load.force.parameter.value for load in slider_crank.loads] == [-40]
    assert slider_crank.gravity.y.value == -9.81
    assert slider_crank.simulation.end == 2


def test_bodies_stand_in_the_order_of_the_file_with_clearance_links_last(slider_crank):
    assert [*slider_crank.bodies] == ["crank", "rod", "piston", "r1"]


def test_clearance_displaces_the_end_of_its_bar_only(slider_crank):
    points = {name: [*body.points] for name, body in slider_crank.bodies.items()}
    assert points == {
        "crank": ["O", "A"], "rod": ["A.r1", "B"], "piston": ["B"], "r1": ["A", "A.r1"],
    }  # fmt: skip


def test_axis_through_a_ground_joint_starts_there(slider_crank):
    assert slider_crank.bodies["piston"].guide.origin == slider_crank.ground["O"]


def test_ideal_has_no_clearances(slider_crank):
    ideal = slider_crank.ideal()
    assert [*ideal.bodies] == ["crank", "rod", "piston"]
    assert [*ideal.bodies["rod"].points] == ["A", "B"]
    assert ideal.name == "Slider-crank (ideal)"
    assert not ideal.initial


def test_ideal_has_no_friction_in_clearances(slider_crank):
    rubbing = slider_crank.with_component(ClearanceDamper(index=0, clearance="r1", damping=0.1))
    assert [load.measure for load in rubbing.loads] == [Slide("piston"), Turn("r1", "rod")]
    assert rubbing.ideal().loads == slider_crank.loads


def test_with_component(slider_crank):
    more = slider_crank.with_component(FreeAngle(name="rod", angle=1))
    assert [*more.initial] == ["r1", "rod"]
    assert [*slider_crank.initial] == ["r1"]
    with pytest.raises(InputError, match=r"free\.rot: unknown bar 'rot'; did you mean 'rod'\?"):
        slider_crank.with_component(FreeAngle(name="rot", angle=1))


def test_problems_have_lines_where_there_is_a_file(slider_crank):
    path = ("bars", "rod", "length")
    assert str(mechanism(TEXT).problem(path, "too short")) == (
        "line 7, column 25, bars.rod.length: too short"
    )
    assert str(slider_crank.problem(path, "too short")) == "bars.rod.length: too short"


def test_an_added_component_is_reported_at_its_section():
    read = mechanism(TEXT)
    with pytest.raises(InputError) as caught:
        read.with_component(Drive(name="rot", angle=0, speed=1))
    (problem,) = caught.value.problems
    assert (problem.line, problem.path) == (12, "drives.rot")


def test_name_defaults_to_the_file():
    assert mechanism(TEXT.replace("name: Slider-crank\n", "")).name == "m"


def test_a_component_says_what_it_contributes():
    class Nothing(Component):
        section = "nothing"

    assert Nothing().path == ("nothing",)
    assert Nothing().problems() == ()
    assert Nothing().references().joints == ()
    with pytest.raises(TypeError, match="Nothing contributes no terms"):
        Nothing().terms()
