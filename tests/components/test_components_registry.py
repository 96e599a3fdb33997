import pytest
from component_reading import mechanism

from linkages.components.bar import Bar
from linkages.components.contributed.component import Component
from linkages.components.damper import GuideDamper, LineDamper
from linkages.components.drive import Drive, SliderDrive
from linkages.components.free import FreeAngle, FreePosition
from linkages.components.load import JointForce, SliderForce
from linkages.components.mechanisms.registry import SECTIONS
from linkages.components.plate import Plate
from linkages.components.spring import JointSpring
from linkages.components.torque import BarTorque, TorqueBetweenBars
from linkages.components.torsional_damper import ClearanceDamper, DamperBetweenBars, JointDamper
from linkages.components.torsional_spring import BarSpring, SpringBetweenBars

ENTRIES = {
    "bars": [({"joints": ["O", "A"]}, Bar), ({"points": {}}, Plate), ("nonsense", Bar)],
    "drives": [({"angle": 1}, Drive), ({"position": 1}, SliderDrive), ({"law": "t"}, Drive)],
    "loads": [
        ({"slider": "s"}, SliderForce),
        ({"joint": "A"}, JointForce),
        ({"bar": "b"}, BarTorque),
        ({"bars": ["a", "b"]}, TorqueBetweenBars),
    ],
    "springs": [
        ({"between": ["A", "B"]}, JointSpring),
        ({"between_bars": ["a", "b"]}, SpringBetweenBars),
        ({"bar": "a"}, BarSpring),
    ],
    "dampers": [
        ({"joint": "A", "bars": ["a", "b"]}, JointDamper),
        ({"between": ["A", "B"]}, LineDamper),
        ({"bars": ["a", "b"]}, DamperBetweenBars),
        ({"slider": "s"}, GuideDamper),
        ({"clearance": "r1"}, ClearanceDamper),
    ],
    "free": [({"angle": 1}, FreeAngle), ({"position": 1}, FreePosition), (None, FreeAngle)],
}


@pytest.mark.parametrize(
    ("section", "raw", "expected"),
    [(section, *entry) for section, entries in ENTRIES.items() for entry in entries],
)
def test_choice_between_components(section, raw, expected):
    assert SECTIONS[section].choose(raw) is expected


@pytest.mark.parametrize("section", SECTIONS)
@pytest.mark.parametrize("raw", [{}, {"points": {}}, {"position": 0}, [], "x", None])
def test_every_component_knows_its_section(section, raw):
    chosen = SECTIONS[section].choose(raw)
    assert issubclass(chosen, Component)
    assert chosen.section == section


REST = {
    "joints": "bars: {crank: {joints: [O, A], length: 0.3}}",
    "bars": "joints: {O: [0, 0]}",
}
FRAME = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3}, rod: {joints: [A, B], length: 1}}
"""
PISTON = "sliders: {piston: {joint: B, through: O}}\n"


@pytest.mark.parametrize("section", SECTIONS)
def test_examples_can_be_used(section):
    """What messages offer as an example is itself a valid entry."""
    about = SECTIONS[section]
    entry = {
        "mapping": f"\n  {about.example}",
        "list": f"\n- {about.example}",
        "value": about.example,
    }
    rest = REST.get(section, FRAME)
    if section in ("loads", "assembly", "springs", "racks", "stops", "cams"):
        rest += PISTON
    text = f"{rest}\n{section}: {entry[about.form]}\n"
    assert any(c.section == section for c in mechanism(text).components)
