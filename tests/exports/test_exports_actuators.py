"""Exports of mechanisms with drives of points and actuators."""

from runpy import run_path

import pytest

import linkages
from linkages.errors import InputError
from linkages.exports import Subject, files_of

BOOM = """
gravity: [0, -9.81]
joints: {O: [0, 0], F: [0.2, -0.3]}
bars:
  boom: {points: {O: [0,0], A: [2,0], K: [0.8, 0.1]}, mass: 50, center: [1, 0], inertia: 17}
  stick: {points: {A: [0, 0], P: [1.2, 0]}, mass: 25, center: [0.6, 0], inertia: 3}
drives: {P: {waypoints: [[2, -0.3], [2.3, -0.5], [2.2, -0.9]], progress: 0.5*t}}
actuators: {lift: {between: [F, K]}, crowd: {bars: [boom, stick]}}
assembly: {A: left}
simulate: {end: 2, samples: 5}
"""


def test_a_program_has_motions_and_efforts_of_actuators(tmp_path):
    made = linkages.loads(BOOM)
    (name, text), *_ = files_of(Subject(made, "boom"), "python", {}).items()
    (tmp_path / name).write_text(text, encoding="utf-8")
    program = run_path(str(tmp_path / name))
    data = linkages.simulate(made, outputs="all").data
    p, state = program["start"]()
    for k, time in enumerate(data.time.values):
        found = dict(zip(program["NAMES"], program["outputs"](time, state, p), strict=True))
        for name, drive in (("lift", "linear_actuator"), ("crowd", "rotary_actuator")):
            effort = float(data.drive_effort.sel(drive=name)[k])
            # the same operations, of another library
            assert found[f"{name}.effort"] == pytest.approx(effort, rel=1e-11)
            acceleration = float(data[f"{drive}_acceleration"].sel({drive: name})[k])
            assert found[f"{name}.acceleration"] == pytest.approx(acceleration, abs=1e-11)
        assert found["actuators.dexterity"] == pytest.approx(float(data.dexterity[k, 0]), rel=1e-12)
        reaction = float(data.joint_reaction.sel(joint="O", axis="y")[k])
        assert found["O.y reaction"] == pytest.approx(reaction, rel=1e-10)


def test_mujoco_has_none_of_them():
    with pytest.raises(InputError) as caught:
        files_of(Subject(linkages.loads(BOOM), "boom"), "mjcf", {})
    texts = [str(problem) for problem in caught.value.problems]
    assert any("drives.P: drives of points are not exported to MuJoCo" in text for text in texts)
    assert sum("actuators in the place of drives" in text for text in texts) == 2
