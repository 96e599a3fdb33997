"""Mechanisms as text and as files: what is written is read as an equal mechanism."""

import errno
import re
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.reading.document import shipped

PENDULUM = linkages.Mechanism(
    name="Built in Python",
    components=(
        linkages.JointDamper(index=4, joint="O", damping=0.1),
        linkages.FreeAngle(name="arm", angle="30 deg", speed=0.1),
        linkages.Bar(name="arm", joints=("O", "A"), length="10 in", mass=1 / 3),
        linkages.UniformGravity(acceleration=(0, "-9.81 m/s^2")),
        linkages.GroundJoint(name="O", position=(0, 0)),
        linkages.BarTorque(
            index=7, bar="arm", torque={"harmonic": {"amplitude": 2, "frequency": 3}}
        ),
        linkages.JointDamper(index=2, joint="O", damping="0.2/2"),
    ),
)


@pytest.mark.parametrize("name", shipped())
def test_what_is_saved_is_read_as_the_same(name, tmp_path):
    mechanism = linkages.load(name)
    file = mechanism.save(tmp_path / "other.yaml")
    assert linkages.load(file) == mechanism
    assert linkages.loads(mechanism.to_yaml()) == mechanism
    assert [path.name for path in tmp_path.iterdir()] == ["other.yaml"]  # nothing temporary


def test_a_mechanism_built_in_python_is_saved_whatever_the_order_of_its_components():
    again = linkages.loads(PENDULUM.to_yaml())
    assert again == PENDULUM
    assert again.name == "Built in Python"
    assert [c.damping for c in again.components if c.section == "dampers"] == [0.1, 0.1]


def test_changed_mechanisms_are_saved_as_they_are_now(tmp_path):
    mechanism = linkages.load("ninebar")
    for changed in (mechanism.ideal(), mechanism.with_values({"clearances.r1.size": 1e-4 / 3})):
        assert linkages.load(changed.save(tmp_path / "m.yaml")) == changed
        assert changed != mechanism


def test_a_failed_save_leaves_the_file_that_was_there(tmp_path, monkeypatch):
    file = PENDULUM.save(tmp_path / "m.yaml")
    before = file.read_text(encoding="utf-8")

    def broken(_):
        raise MemoryError

    monkeypatch.setattr("linkages.components.mechanisms.mechanism.as_yaml", broken)
    with pytest.raises(MemoryError):
        PENDULUM.save(file)
    assert file.read_text(encoding="utf-8") == before
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    "value", [0.12, np.float64(0.12), np.array(0.12), "120 mm", "(10 + 2) cm", "quantity"], ids=repr
)
def test_values_are_floats_texts_quantities_and_scalars_of_numpy(value):
    import pint

    given = pint.Quantity(12, "cm") if isinstance(value, str) and value == "quantity" else value
    found = linkages.load("slider-crank").with_values({"bars.rod.length": given})
    assert next(c for c in found.components if c.path == ("bars", "rod")).length == pytest.approx(
        0.12,
        rel=1e-15,
        abs=0.0,  # conversion of units rounds
    )
    assert found == linkages.load("slider-crank", set={"bars.rod.length": given})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"bars.rd.length": 0.1}, "bars.rd.length: unknown name 'rd'; did you mean 'rod'?"),
        ({"bars.rod.lenght": 0.1}, "bars.rod.lenght: unknown key 'lenght'; did you mean 'length'?"),
        ({"bar.rod.length": 0.1}, "unknown key 'bar'; did you mean 'bars'?"),
        ({"bars.rod.length": "5 kg"}, "kg is a mass, not a length (from set bars.rod.length=5 kg)"),
        ({"bars.rod.length": -1}, "expected a length > 0 (metres, or with a unit), found -1"),
    ],
)
def test_wrong_values_name_their_path_and_no_line(values, message):
    with pytest.raises(linkages.InputError) as caught:
        linkages.load("slider-crank").with_values(values)
    assert message in str(caught.value)
    assert "line" not in str(caught.value).split("\n", 1)[1]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: m.with_values(["bars.rod.length=1"]), "expected a mapping of paths to values"),
        (lambda _: linkages.load(3), "file must be a path or a name, found 3"),
        (lambda _: linkages.loads(None), "text must be the text of a definition, found None"),
        (lambda _: linkages.load("pendulum", set="a=1"), "expected a mapping of paths to values"),
        (lambda m: m.with_component(3), "components must be bars, joints and the like, found 3"),
        (lambda m: m.with_state([1]), r"state must be a mapping such as .* found \[1\]"),
        (lambda _: linkages.simulate("pendulum"), "mechanism must be one, .* found 'pendulum'"),
        (lambda m: linkages.simulate(m, outputs=3), "outputs must be names, or 'all', found 3"),
        (lambda _: linkages.open(3), "path must be a file or a folder, found 3"),
        (
            lambda m: linkages.bifurcation(m, {"bars.rod.length": [1, 2]}, initial={"a": 1}),
            "initial must be a list of mappings",
        ),
    ],
)
def test_arguments_of_a_wrong_type_are_named(call, message):
    with pytest.raises(TypeError, match=message):
        call(linkages.load("slider-crank"))


def test_a_mechanism_shows_what_it_consists_of():
    assert repr(PENDULUM) == (
        "Mechanism('Built in Python', gravity=1, joints=1, bars=1, free=1, loads=1, dampers=2)"
    )


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"rd": (1, 2)}, "state: unknown body 'rd'; did you mean 'rod'?"),
        ({"rod": 1}, "state: expected the value and the rate of rod, found 1"),
    ],
)
def test_states_that_make_no_sense_are_named(state, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        linkages.load("pendulum").with_state(state)


def test_a_full_disk_names_the_file(tmp_path, monkeypatch):
    """The system names no file where a write fails."""

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match="No space left") as caught:
        linkages.load("pendulum").save(tmp_path / "kept.yaml")
    assert caught.value.filename == str(tmp_path / "kept.yaml")
    assert list(tmp_path.iterdir()) == []
