"""``equilibrium``: what it prints and writes, and that results are computed again."""

import json

import numpy as np
import pytest
from PIL import Image
from scipy.io import loadmat

import linkages

TRUSS = """
name: Truss
joints: {A: [-1, 0], B: [1, 0], G: [0, 0]}
sliders: {apex: {joint: P, through: G, angle: 90 deg, mass: 2}}
springs:
  - {between: [A, P], stiffness: 1000, length: 1.2}
  - {between: [B, P], stiffness: 1000, length: 1.2}
loads: [{slider: apex, force: -10}]
free: {apex: {position: 0.5, speed: 0}}
"""


@pytest.fixture
def truss(tmp_path):
    (tmp_path / "m.yaml").write_text(TRUSS)
    return "m.yaml"


def found(result):
    assert result.code == 0, result.err
    assert not result.err
    return json.loads(result.out)


def test_json_has_the_keys_of_equilibria(truss, cli, tmp_path):
    said = found(cli("equilibrium", truss, "--json", "--matrices", "npz", "--out", "o"))
    assert [one["stable"] for one in said["equilibria"]] == [True, True, False]
    for number, one in enumerate(said["equilibria"], 1):
        assert one["state"].keys() == {"apex.position", "apex.velocity"}
        assert "interval" not in one
        for mode in one["modes"]:
            assert {"frequency", "damping_ratio", "eigenvalue"} <= mode.keys()
        with np.load(tmp_path / f"o/linear_{number}.npz") as stored:
            assert stored["A"].tolist() == one["linear"]["A"]
            assert stored["states"].tolist() == one["linear"]["states"]
            assert stored["inputs"].tolist() == ["apex.force"]
    names = {path.rsplit("/")[-1] for path in said["files"]}
    assert names == {
        "equilibrium.nc", "equilibrium.csv", "linear_1.npz", "linear_2.npz", "linear_3.npz",
        "equilibria.png", "modes.png", "bode_1.png", "bode_2.png", "bode_3.png",
    }  # fmt: skip


def test_dry_friction_has_an_interval(truss, cli):
    rubs = "friction=[{slider: apex, force: 5}]"
    said = found(cli("equilibrium", truss, "--set", rubs, "--json", "--no-figures"))
    for one in said["equilibria"]:
        low, high = one["interval"]["apex.position"]
        assert low < one["state"]["apex.position"] < high
        assert one["modes"] == []
    shown = cli("equilibrium", truss, "--set", rubs, "--no-figures")
    assert " … " in shown.out
    assert "dry friction holds it" in shown.out


def test_what_was_asked_is_computed_again(truss, cli, tmp_path):
    arguments = ("--solve", "loads[0].force", "--state", "apex.position=40 cm", "--starts", "50",
                 "--observed", "P.y position", "--inputs", "loads[0]", "--frequencies", "1:10:5",
                 "--no-figures", "--out", "o")  # fmt: skip
    shown = cli("equilibrium", truss, *arguments)
    assert shown.code == 0, shown.err
    assert "solved for: loads[0].force = -91." in shown.out
    opened = linkages.open(tmp_path / "o" / "equilibrium.nc")
    again = opened.compute()
    for name in ("state", "eigenvalue", "A", "D", "response"):
        np.testing.assert_array_equal(again[name], opened.data[name])
    assert opened.analysis == "equilibrium"
    assert again.sizes["response_frequency"] == 5
    assert again["output"].to_numpy().tolist() == ["P.y position"]
    renewed = found(cli("equilibrium", "o/equilibrium.nc", "--json", "--no-figures"))
    assert renewed["solved"] == json.loads(again.attrs["solved"])


def test_films_and_matrices_for_matlab(truss, cli, tmp_path):
    options = ("--film", "--no-figures", "--matrices", "mat", "--out", "o")
    result = cli("equilibrium", truss, *options)
    assert result.code == 0, result.err
    with Image.open(tmp_path / "o/mode_1_1.gif") as film:
        assert film.n_frames == 40
    stored = loadmat(tmp_path / "o/linear_3.mat")
    assert stored["A"].shape == (2, 2)
    assert stored["A"][0].tolist() == [0.0, 1.0]
    assert [str(each.item()) for each in stored["outputs"].ravel()] == ["apex.position"]
    assert not (tmp_path / "o/mode_3_1.gif").exists()  # it does not swing


def test_drives_are_held_at_a_time_or_move(cli):
    command = ("equilibrium", "idling-engine", "--at", "10 ms", "--json", "--no-figures")
    said = found(cli(*command))
    assert said["time"] == 0.01
    assert said["equilibria"][0]["drive_effort"].keys() == {"crank"}
    moving = found(cli(*command, "--moving"))
    assert moving["moving"]
    assert moving["equilibria"][0]["reason"].startswith("frozen coefficients")
    shown = cli(*command[:-2], "--moving", "--no-figures")
    assert "no statement on stability" in shown.out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--state", "apex.angle=1"), "found no coordinate 'apex.angle'"),
        (("--solve", "loads[0].force"), "--solve"),
        (("--solve", "loads[0].farce", "--state", "apex.position=0.4"), "loads[0].farce"),
        (("--inputs", "apex.torque"), "found no input 'apex.torque'"),
        (("--observed", "apex.angle"), "apex has no 'angle'"),
        (("--frequencies", "3"), "--frequencies"),
        (("--at", "noon"), "noon"),
    ],
    ids=str,
)
def test_bad_input_is_one_sentence_and_code_2(arguments, expected, truss, cli, tmp_path):
    cli.refused("equilibrium", truss, *arguments, "--out", "o", says=expected)
    assert not (tmp_path / "o").exists()


def test_no_equilibrium_is_code_1(truss, cli):
    slides = ("--set", "springs=[]")
    result = cli("equilibrium", truss, *slides)
    assert result.code == 1
    assert "no equilibrium was found from 100 starts" in result.err
