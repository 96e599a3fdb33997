"""Components and outputs from outside the package: by a call, and by entry points."""

import sys
from importlib import metadata
from typing import ClassVar

import pytest

import linkages
from linkages import discovery
from linkages.components.contributed.component import (
    ListedComponent,
    References,
    Section,
    component,
)
from linkages.components.contributed.terms import Parameter, PointMass
from linkages.components.mechanisms import registry
from linkages.components.rigid_bodies import JointMass
from linkages.kernel import outputs
from linkages.kernel.outputs import Variable
from linkages.spec.quantities import Mass, Name

PENDULUM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
free: {rod: {angle: 0.5, speed: 0}}
"""


@component
class Pans(ListedComponent):
    """Equal masses at two joints.

    Parameters
    ----------
    index
        Place in the list.
    joints
        Where they are.
    mass
        Of each, in kg.
    """

    section: ClassVar[str] = "pans"
    opens: ClassVar[Section] = Section("list", "{joints: [A, B], mass: 2 kg}")

    index: int
    joints: tuple[Name, Name]
    mass: Mass

    def references(self):
        return References(
            joints=tuple(((*self.path, "joints", i), j) for i, j in enumerate(self.joints))
        )

    def terms(self):
        mass = Parameter((*self.path, "mass"), self.mass)
        return tuple(PointMass(joint, mass, self.path) for joint in self.joints)


TOTAL = Variable(
    ("bar",),
    "rad",
    "twice the angle",
    lambda model: [2.0 * model.positions.angle(name) for name in outputs.labels(model, "bar")],
)


@pytest.fixture
def pans():
    linkages.register(Pans)
    yield Pans
    linkages.unregister("Pans")


def test_a_component_is_read_checked_and_written_like_all_others(pans):
    text = PENDULUM + "pans: [{joints: [O, P], mass: 500 g}]\n"
    mechanism = linkages.loads(text)
    assert mechanism.components[-1] == pans(index=0, joints=("O", "P"), mass=0.5)
    assert linkages.loads(mechanism.to_yaml()) == mechanism
    assert linkages.Pans is pans
    heavier = mechanism.with_values({"pans[0].mass": "1 kg"})
    swings = [
        linkages.simulate(m, end=1.0).data.bar_angle[-1, 0]
        for m in (heavier, linkages.loads(PENDULUM + "masses: {P: 1}\n"))
    ]
    assert float(swings[0]) == pytest.approx(float(swings[1]), abs=1e-9)
    with pytest.raises(linkages.InputError, match="did you mean 'mass'"):
        linkages.loads(text.replace("mass: 500", "mas: 500"))


def test_what_is_registered_can_be_taken_away_and_replaced(pans):
    linkages.register(pans)  # as when the cell of a notebook runs again
    assert sum(model is pans for model in registry.SECTIONS["pans"].models) == 1
    linkages.unregister("Pans")
    with pytest.raises(linkages.InputError, match="unknown key 'pans'"):
        linkages.loads(PENDULUM + "pans: [{joints: [O, P], mass: 500 g}]\n")
    with pytest.raises(KeyError):
        linkages.unregister("Pans")
    linkages.register(pans)


def test_two_components_of_a_section_need_a_key_that_tells_them():
    class Other(JointMass):
        """Another one."""

        section: ClassVar[str] = "masses"

    with pytest.raises(ValueError, match="section 'masses': expected one component that no key"):
        linkages.register(Other)
    assert linkages.loads(PENDULUM + "masses: {P: 1}\n").point_masses


def test_an_output_is_computed_labelled_and_suggested():
    linkages.register(TOTAL, "doubled_angle")
    try:
        data = linkages.simulate(
            linkages.loads(PENDULUM), end=0.5, samples=3, outputs=["bar_angle", "doubled_angle"]
        ).data
        assert data.doubled_angle.to_numpy() == pytest.approx(2 * data.bar_angle.to_numpy())
        assert data.doubled_angle.attrs == {"units": "rad", "long_name": "twice the angle"}
        with pytest.raises(ValueError, match="did you mean 'doubled_angle'"):
            linkages.simulate(linkages.loads(PENDULUM), outputs=["doubled_angel"])
    finally:
        linkages.unregister("doubled_angle")
    assert "doubled_angle" not in outputs.VARIABLES


@pytest.mark.parametrize(
    ("thing", "name", "error"),
    [
        (TOTAL, "bar_angle", "not taken, found 'bar_angle'"),
        (TOTAL, "no name", "not taken, found 'no name'"),
        (3, "", "expected a component with a section, found 3"),
        (ListedComponent, "", "expected a component with a section"),
    ],
)
def test_what_cannot_be_registered_is_named(thing, name, error):
    with pytest.raises((TypeError, ValueError), match=error):
        linkages.register(thing, name)


def test_entry_points_of_other_packages_are_found(monkeypatch):
    here = __name__
    points = {
        "linkages.components": [metadata.EntryPoint("pans", f"{here}:Pans", "linkages.components")],
        "linkages.outputs": [
            metadata.EntryPoint("doubled", f"{here}:TOTAL", "linkages.outputs"),
            metadata.EntryPoint("broken", f"{here}:NOTHING", "linkages.outputs"),
        ],
    }
    assert sys.modules[here]
    monkeypatch.setattr(discovery, "entry_points", lambda group: points[group])
    caches = discovery.plugged, registry._known, outputs._all
    for cache in caches:
        cache.cache_clear()
    try:
        assert linkages.loads(PENDULUM + "pans: [{joints: [O, P], mass: 1}]\n").point_masses
        with pytest.warns(UserWarning, match=r"entry point linkages.outputs: .*NOTHING"):
            assert outputs.VARIABLES["doubled"] is TOTAL
        assert "broken" not in outputs.VARIABLES
    finally:
        for cache in caches:
            cache.cache_clear()
