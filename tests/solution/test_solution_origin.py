"""What results say about where they come from."""

import json

import linkages
from linkages.solution.origin import origin_of


def test_options_are_those_of_the_file_and_those_given():
    mechanism = linkages.load("ninebar", set={"simulate.rtol": 1e-8})
    options = json.loads(origin_of(mechanism, {"periods": 7, "rtol": None})["options"])
    assert (options["rtol"], options["periods"], options["method"]) == (1e-8, 7, "dop853")
    assert json.loads(origin_of(mechanism, {"rtol": 1e-6})["options"])["rtol"] == 1e-6


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
