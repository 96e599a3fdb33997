"""What results say about where they come from."""

import json

import xarray as xr

import linkages
from linkages.solution.files import origin_of


def test_options_are_those_of_the_file_and_those_given(tmp_path):
    """So that they are arguments with which the same comes out, whatever the file says."""
    mechanism = linkages.load("pendulum", set={"simulate.rtol": 1e-8, "simulate.end": 1})
    solution = linkages.simulate(mechanism, samples=7)
    solution.save(tmp_path)
    with xr.open_dataset(tmp_path / "simulate.nc", engine="h5netcdf") as saved:
        options = json.loads(saved.attrs["options"])
    said = {key: options[key] for key in ("rtol", "samples", "end", "method", "step")}
    assert said == {"rtol": 1e-8, "samples": 7, "end": 1.0, "method": "dop853", "step": None}
    again = linkages.simulate(linkages.load("pendulum"), **options)
    assert again.data.identical(solution.data)


def test_values_that_are_set_are_in_the_definition():
    mechanism = linkages.load("ninebar", set={"clearances.r1.size": "0.2 mm"})
    assert "size: 0.2 mm" in origin_of(mechanism, {})["definition"]


def test_what_python_changed_is_in_the_definition(tmp_path):
    mechanism = linkages.load("ninebar")
    damper = linkages.ClearanceDamper(index=0, clearance="r1", damping=1e-4)
    for number, changed in enumerate(
        (
            mechanism,
            mechanism.ideal(),
            mechanism.with_component(damper),
            mechanism.with_state({"r1": (0.1, 0.0)}),
            linkages.Mechanism(components=mechanism.components, name="made in Python"),
        )
    ):
        path = tmp_path / f"{number}.yaml"
        path.write_text(origin_of(changed, {})["definition"], encoding="utf-8")
        again = linkages.load(path)
        # kinds of components stand in the order of the sections
        assert sorted(again.components, key=repr) == sorted(changed.components, key=repr)
        assert again.name == changed.name
