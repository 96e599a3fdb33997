"""Results read from disk are computed again bit for bit."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

import linkages

SHORT = {"simulate.end": 0.1, "simulate.samples": 21}


@pytest.mark.slow_except("pendulum-*", "double*")
@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("ninebar", {}),
        ("ninebar", {"method": "rk4", "step": 1e-5}),
        ("slider-crank", {"outputs": "all"}),
        ("pendulum", {"times": [0.02, 0.05, 0.1], "state": {"rod": (0.3, np.float64(1.0))}}),
        ("pendulum", {"state": np.array([0.3, 1.0]), "events": {"rod.angle": "down"}}),
        ("double-pendulum", {"method": "auto", "rtol": 1e-9, "atol": 1e-7}),
    ],
)
def test_a_solution_is_computed_again_bit_for_bit(name, given, tmp_path):
    mechanism = linkages.load(name, set=SHORT)
    solution = linkages.simulate(mechanism, **given)
    solution.save(tmp_path)
    opened = linkages.open(tmp_path)
    assert opened.analysis == "simulate"
    assert opened.notes == solution.notes
    assert opened.version == f"linkages {linkages.__version__}"
    assert opened.complete
    again = opened.compute()
    assert again.data.equals(solution.data)
    assert again.data.equals(opened.data)
    for event, found in solution.events.items():
        assert again.events[event].equals(found)


def test_what_was_changed_in_python_is_computed_again(tmp_path):
    mechanism = linkages.load("ninebar", set=SHORT)
    damper = linkages.ClearanceDamper(index=0, clearance="r1", damping=1e-4)
    changed = mechanism.with_component(damper).with_values({"clearances.r1.size": "0.2 mm"})
    solution = linkages.simulate(changed)
    nc, _ = solution.save(tmp_path)
    opened = linkages.open(nc)
    assert opened.mechanism == solution.mechanism
    assert opened.compute().data.equals(solution.data)
    assert not linkages.simulate(mechanism).data.equals(solution.data)
    assert repr(opened) == f"Opened({str(nc)!r}, simulate of 'Nine-bar press mechanism')"


def test_what_is_no_result_is_named(tmp_path):
    with pytest.raises(linkages.InputError, match="no such file or folder"):
        linkages.open(tmp_path / "nothing")
    with pytest.raises(linkages.InputError, match="one file of results, found none"):
        linkages.open(tmp_path)
    nc, _ = linkages.simulate(linkages.load("pendulum", set=SHORT)).save(tmp_path)
    for name in ("other", "third"):
        shutil.copy(nc, tmp_path / f"{name}.nc")
    assert linkages.open(tmp_path).file == nc
    nc.unlink()
    with pytest.raises(linkages.InputError, match=r"found other.nc or third.nc"):
        linkages.open(tmp_path)
    opened = linkages.open(tmp_path / "other.nc")
    assert opened.analysis == "simulate"
    opened = replace(opened, analysis="other")
    with pytest.raises(linkages.InputError, match="'other' is not computed again; expected one of"):
        opened.compute()
    broken = tmp_path / "broken.nc"
    broken.write_bytes(b"no")
    with pytest.raises(linkages.InputError, match="cannot be read"):
        linkages.open(broken)
    assert json.loads(opened.data.attrs["arguments"])["samples"] == 21
