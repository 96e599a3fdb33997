import pytest
from component_reading import complaints, component, mechanism

from linkages.components.contributed.contact_laws import contact_laws
from linkages.components.contributed.normal_forces import Contact, stiffness_of_cylinders
from linkages.components.contributed.terms import Displacement, Initial
from linkages.components.joint_clearances import ContactClearance
from linkages.kernel.system import System
from linkages.kernel.varying import Varying

ENGINE = """joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}}
  rod: {{joints: [A, B], length: 0.14, mass: 0.5, center: 0.07}}
sliders: {{piston: {{joint: B, through: O, mass: 0.4}}}}
clearances:
  gap: {{joint: A, bar: rod, size: 0.1 mm, {keys}}}
drives: {{crank: {{angle: 0, speed: 600 rpm}}}}
assembly: {{B: [0.18, 0]}}
"""
BARE = ContactClearance(name="gap", joint="A", bar="rod", size=1e-4, contact="hertz", stiffness=2e9)

FILM = "contact: lubricated, viscosity: 40 mPa*s"
PIN = "width: 1 cm, pin_radius: 1 cm"

CYLINDER = "modulus: 207 GPa, stiffness_model: cylinder"


def engine(keys):
    return ENGINE.format(keys=keys)


def test_same_from_yaml_and_python():
    assert component(engine("contact: hertz, stiffness: 2e9"), "clearances", "gap") == BARE
    assert component(engine("contact: hertz, stiffness: 2e9 N/m^1.5"), "clearances", "gap") == BARE
    millimetres = component(engine("contact: hertz, stiffness: 2e9 N/mm^1.5"), "clearances", "gap")
    # 1 N/mm^1.5 is 1000^1.5 N/m^1.5
    assert millimetres.stiffness == pytest.approx(2e9 * 1000**1.5, rel=1e-15)


def test_stiffness_follows_from_material_and_radii():
    text = engine("contact: hertz, modulus: 207 GPa, poisson: 0.3, pin_radius: 9.5 mm")
    steel = component(text.replace("0.1 mm", "0.5 mm"), "clearances", "gap")
    *_, contact = steel.terms()
    stiffness, exponent = contact.normal.numbers
    # of a steel pin as in the literature, 6.61e10 N/m^1.5
    assert stiffness.value == pytest.approx(6.6102e10, rel=1e-5)
    assert exponent.value == 1.5


def test_stiffness_of_cylinders_brings_its_exponent():
    made = component(engine(f"contact: hertz, {CYLINDER}, width: 2 cm"), "clearances", "gap")
    *_, contact = made.terms()
    found = tuple(number.value for number in contact.normal.numbers)
    assert found == stiffness_of_cylinders(207e9, 0.3, 1e-4, 0.02)
    wide = engine(f"contact: hertz, {CYLINDER}, width: 2 cm").replace("0.1 mm", "20 mm")
    (complaint,) = complaints(wide)
    assert "expected a size from 5e-06 to 0.01 m, for which it is known" in complaint


def test_its_offset_has_two_free_coordinates():
    made = ContactClearance(
        name="gap", joint="A", bar="rod", size=1e-4, contact="hertz", stiffness=2e9,
        offset=(1e-5, -2e-5), rate=(0.1, 0.2),
    )  # fmt: skip
    displacement, x, y, contact = made.terms()
    assert isinstance(displacement, Displacement)
    assert (displacement.joint, displacement.body, displacement.renamed) == ("A", "rod", "A.gap")
    assert [link.name for link in displacement.links] == ["gap.x", "gap.y"]
    assert all(link.mass.absent and not link.rotates for link in displacement.links)
    path = ("clearances", "gap")
    assert (x, y) == (
        Initial("gap.x", 1e-5, 0.1, path, (("offset", 0), ("rate", 0))),
        Initial("gap.y", -2e-5, 0.2, path, (("offset", 1), ("rate", 1))),
    )
    assert isinstance(contact, Contact)
    assert contact.geometry.hole


def test_an_offset_that_is_not_written_has_entries():
    read = mechanism(engine("contact: hertz, stiffness: 2e9"))
    moved = read.with_values({"clearances.gap.offset[1]": 1e-5, "clearances.gap.rate[0]": "1 mm/s"})
    assert moved.initial["gap.x"].speed == 1e-3
    assert (moved.initial["gap.x"].position, moved.initial["gap.y"].position) == (0.0, 1e-5)
    varying = Varying(read)
    points = [{"clearances.gap.offset[1]": 1e-6 * k, "clearances.gap.size": 1e-4} for k in range(9)]
    along = varying.along(points)
    assert along.columns == list(range(9))
    rows = [along.system(k).state.tolist() for k in range(9)]
    assert rows == [System(read.with_values(point)).state.tolist() for point in points]


def test_another_state_moves_the_offset_alone():
    found = mechanism(engine("contact: hertz, stiffness: 2e9"))
    moved = found.with_state({"gap.y": (3e-5, 0.5)})
    (clearance,) = moved.clearances
    assert (clearance.offset, clearance.rate) == ((0.0, 3e-5), (0.0, 0.5))
    assert found.ideal().clearances == ()


@pytest.mark.parametrize("law", contact_laws())
def test_every_law_says_what_it_lacks(law):
    found = complaints(engine(f"contact: {law}, pin_radius: 8 mm"))
    missing = [f"missing key {key!r}, which {law} needs" for key in contact_laws()[law].needs]
    assert all(text in complaint for text, complaint in zip(missing, found, strict=True))
    assert missing


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("contact: hertz, stiffness: -1", "stiffness: expected a stiffness > 0"),
        ("contact: hertz, stiffness: 1e9 N/m", "expected a stiffness in N/m^1.5, for the exponent"),
        ("contact: hertz, stiffness: 1e9 kg", "stiffness: expected a stiffness > 0"),
        ("contact: hunt-crosley, stiffness: 1e9", "did you mean 'hunt-crossley'?"),
        ("contact: flores, stiffness: 1, restitution: 1.2", "at most 1, found 1.2"),
        ("contact: flores, stiffness: 1, restitution: 0", "restitution: expected a number > 0"),
        ("contact: hertz, stiffness: 1, damping: 2", "hertz has no 'damping'; it takes stiffness"),
        ("contact: hertz, stiffness: 1, friction: 0.1, slip: 1", "missing key 'pin_radius'"),
        ("contact: hertz, stiffness: 1, friction: -0.1", "friction: expected a number >= 0"),
        ("contact: hertz, stiffness: 1, offset: [0, 0.16 mm]", "the pin starts 6e-05 m within"),
        ("contact: hertz, stiffness: 1, offset: [1, 0]", "expected at most 5e-05 m, 0.5 of the"),
        ("contact: restitution, restitution: 1, offset: [0, 0.101 mm]", "0.001 of the size, of"),
        (f"{FILM}, width: 1 cm", "missing key 'pin_radius', which lubricated needs"),
        (f"{FILM}, pin_radius: 1 cm", "missing key 'width', which lubricated needs"),
        (f"{FILM}, {PIN}, stiffness: 1", "lubricated has no 'stiffness'; it takes viscosity"),
        (f"{FILM}, {PIN}, friction: 0.1, slip: 1", "lubricated has no friction; expected the law"),
        (f"{FILM}, {PIN}, offset: [0, 0.1 mm]", "where no oil is between them; expected less than"),
        ("contact: hertz, stiffness: 1, width: 1 cm", "hertz has no 'width'; it takes stiffness"),
        (f"contact: hertz, {CYLINDER}", "missing key 'width': the stiffness of cylinders"),
        (f"contact: hertz, {CYLINDER}, {PIN}, exponent: 1.5", "is no law of cylinders"),
        (f"contact: kelvin-voigt, damping: 1, {CYLINDER}, {PIN}", "is no law of cylinders"),
        ("contact: hertz, stiffness: 1, friction_law: coulom", "did you mean 'coulomb'?"),
        ("contact: hertz, stiffness: 1, static: 0.1", "tanh has no 'static'; it takes friction"),
        ("contact: hertz, stiffness: 1, slip: 0", "slip: expected a speed > 0"),
        ("contact: hertz, stiffness: 1, carries: holes", "did you mean 'hole'?"),
        ("contact: hertz, stiffness: 1, angle: 0", "unknown key 'angle'"),
        ("contact: hertz, modulus: 207 GPa", "missing key 'pin_radius': the stiffness follows"),
        ("contact: hertz, modulus: 1, stiffness: 1, pin_radius: 1", "expected one of the two"),
        ("contact: hertz, modulus: 1, pin_radius: 1, exponent: 2", "is no law of spheres"),
        ("contact: hertz, modulus: 1, pin_radius: 1, poisson: 1", "at most 0.5, found 1"),
    ],
)
def test_bad_entries(keys, expected):
    (complaint,) = complaints(engine(keys))
    assert expected in complaint


def test_dampers_act_on_links_alone():
    text = engine("contact: hertz, stiffness: 1") + "dampers: [{clearance: gap, damping: 0.1}]\n"
    (complaint,) = complaints(text)
    assert "clearance 'gap' opens, so no link turns in it; expected 'friction'" in complaint
