import pytest
from component_reading import mechanism

from linkages.components.actuators import Drive, SliderDrive
from linkages.components.contributed.component import Component
from linkages.components.external_loads import BarTorque, JointForce, SliderForce, TorqueBetweenBars
from linkages.components.mechanisms.registry import SECTIONS
from linkages.components.rigid_bodies import Bar, Plate
from linkages.components.scene import FreeAngle, FreePosition
from linkages.components.springs import (
    BarSpring,
    ClearanceDamper,
    DamperBetweenBars,
    GuideDamper,
    JointDamper,
    JointSpring,
    LineDamper,
    SpringBetweenBars,
)

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
