"""Commands of analyses that are found by themselves."""

import json

import numpy as np
import pytest
import xarray as xr

import linkages


def weights(mechanism, *, factor: float = 1.0, unit: str | None = None, both: bool = False):
    """Mass of every body.

    Parameters
    ----------
    mechanism
        Whose.
    factor
        What masses are multiplied by.
    unit
        What they are in.
    both
        Whether to double them.
    """
    if factor < 0:
        raise ValueError(f"factor must be at least 0, found {factor:g}")
    names = [name for name, body in mechanism.bodies.items() if body.kind != "clearance"]
    masses = [factor * (1 + both) * mechanism.bodies[name].mass.value for name in names]
    attributes = {"units": unit or "kg", "long_name": "mass"}
    bodies = np.array(names, dtype=object)
    data = xr.Dataset({"mass": ("body", masses, attributes)}, {"body": bodies})
    return data.assign_attrs(warning="nothing was weighed" if factor == 0 else "")


@pytest.fixture
def registered():
    linkages.register(weights)
    yield
    linkages.unregister("weights")


@pytest.mark.usefixtures("registered")
def test_an_analysis_is_a_command_and_a_function(cli, tmp_path):
    shown = cli("weights", "pendulum", "--factor", "2", "--both", "--out", "r")
    assert shown.code == 0
    assert "rod" in shown.out
    assert shown.files == {"r", "r/weights.nc", "r/weights.csv"}
    assert (tmp_path / "r/weights.csv").read_text().splitlines() == ["body,mass (kg)", "rod,4.0"]
    opened = linkages.open(tmp_path / "r")
    assert opened.compute().mass.to_numpy() == opened.data.mass.to_numpy() == [4.0]
    assert linkages.weights(linkages.load("pendulum")).mass.item() == 1.0


@pytest.mark.usefixtures("registered")
def test_it_prints_json_takes_values_and_warns(cli):
    shown = cli("weights", "pendulum", "--set", "bars.rod.mass=3", "--factor", "0", "--json")
    found = json.loads(shown.out)
    assert found["rows"] == [{"body": "rod", "mass (kg)": 0.0}]
    assert found["warning"] == "nothing was weighed"
    assert "nothing was weighed" in cli("weights", "pendulum", "--factor", "0").out


@pytest.mark.usefixtures("registered")
def test_its_help_comes_from_its_docstring(cli):
    assert "Mass of every body." in cli("--help").out
    shown = cli("weights", "--help").out
    assert "What masses are multiplied by." in shown
    assert "--both" in shown


@pytest.mark.usefixtures("registered")
def test_what_it_refuses_is_wrong_input(cli):
    says = "factor must be at least 0, found -1"
    cli.refused("weights", "pendulum", "--factor", "-1", says=says, files=set())


def test_a_name_that_is_taken_is_refused():
    def entropy(mechanism):
        return mechanism

    with pytest.raises(ValueError, match="not taken, found 'entropy'"):
        linkages.register(entropy)
    assert not hasattr(linkages, "weights")
