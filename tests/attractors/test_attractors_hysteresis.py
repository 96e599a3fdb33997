"""Diagrams over many starts: what coexists, and where it is lost."""

import numpy as np
import pytest
from attractor_systems import V, X, impacts

import linkages
from linkages.attractors.hysteresis import coexisting
from linkages.errors import InputError
from linkages.sweeps.running import Threads

BOX = [f"{X}=-3:0.9:2", f"{V}=-3:3:2"]
FOLD, GRAZING = 0.15168235163828077, 0.45607017003965519  # closed form, 17 digits


def diagram(**how):
    given = {"starts": 6, "within": BOX, "seed": 1} | how
    return linkages.attractor_diagram(impacts(), "parameters.A=0.10:0.50:9", **given)


def test_hysteresis_between_fold_and_grazing():
    """Silent motion is lost at grazing, knocking motion at the fold; each becomes the other."""
    data = diagram()
    assert data.kind.to_numpy().tolist() == ["periodic", "periodic"]
    assert data.touches.to_numpy().ravel().tolist() == [0, 1]
    values = data["parameters.A"].to_numpy()
    exists = data.exists.to_numpy() > 0
    assert (exists[:, 0] == (values < GRAZING)).all()
    assert (exists[:, 1] == (values > FOLD)).all()
    jumps = {
        int(lost): (int(became), float(last), float(behind))
        for lost, became, last, behind in zip(
            *(data[name].to_numpy() for name in ("lost", "became", "last", "behind")), strict=True
        )
    }
    assert jumps[1] == (2, pytest.approx(0.45), pytest.approx(0.5))
    assert jumps[2] == (1, pytest.approx(0.2), pytest.approx(0.15))


def test_what_no_start_meets_is_followed_to():
    """All starts near the silent motion: the knocking one is found above grazing and led back."""
    data = diagram(within=[f"{X}=-0.01:0.01:2", f"{V}=-0.01:0.01:2"])
    exists = data.exists.to_numpy()[:, 1]
    values = data["parameters.A"].to_numpy()
    assert (exists[(values > FOLD) & (values < 0.25)] == 2).all()
    assert exists[-1] == 1
    assert (data.found.to_numpy()[exists == 2, 1] == 0).all()


def test_shares_have_their_intervals_at_each_value():
    data = diagram()
    total = data.found.to_numpy().sum(axis=1)
    assert (total == 6).all()
    fraction, low, high = (data[name].to_numpy() for name in ("fraction", "low", "high"))
    assert ((low <= fraction) & (fraction <= high)).all()
    assert fraction.sum(axis=1) == pytest.approx(1.0)


def test_stretches_of_values_with_the_same_attractors():
    exists = np.array([[1, 0], [1, 2], [1, 1], [0, 1], [1, 1]])
    assert coexisting(exists) == [(1, 2, (1, 2)), (4, 4, (1, 2))]


def test_diagrams_do_not_depend_on_workers_chunks_and_stores(tmp_path, monkeypatch):
    data = diagram(executor=Threads(1))
    monkeypatch.setattr("linkages.attractors.starts.SIDE_BY_SIDE", (5, 5))
    again = diagram(executor=Threads(2), store=tmp_path / "s")
    assert data.drop_attrs().identical(again.drop_attrs())
    assert diagram(store=tmp_path / "s").drop_attrs().identical(data.drop_attrs())


def test_the_direction_of_a_range_makes_no_difference():
    back = linkages.attractor_diagram(
        impacts(), "parameters.A=0.5:0.1:9", starts=6, within=BOX, seed=1
    )
    assert (back.exists.to_numpy()[::-1] == diagram().exists.to_numpy()).all()


def test_a_usual_box_is_about_the_motion_of_the_file():
    """It stays before the stop, from which nothing could start."""
    data = linkages.attractor_diagram(impacts(), "parameters.A=0.1:0.5:3", starts=4)
    assert f"{X}=" in data.attrs["box"]
    side = data.attrs["box"].partition(":")[2].partition(";")[0]
    assert float(side) <= 1.0


def test_a_usual_box_of_a_clearance_with_contact():
    """Its offset is not written in the file: entries of it vary all the same."""
    data = linkages.attractor_diagram(
        linkages.load("contact-slider-crank"), "clearances.gap.size=0.12mm:0.13mm:2",
        starts=1, periods=64, rtol=1e-6,
    )  # fmt: skip
    assert {"clearances.gap.offset[0]", "clearances.gap.rate[1]"} <= {
        side.partition("=")[0] for side in data.attrs["box"].split("; ")
    }
    assert (data.outcome == 0).all()


def test_a_state_is_no_parameter_and_a_parameter_no_side_of_a_box():
    with pytest.raises(ValueError, match="is an initial state"):
        linkages.attractor_diagram(impacts(), f"{X}=0:1:3", starts=4)
    with pytest.raises(ValueError, match=r"parameters\.w is no initial state"):
        diagram(within=["parameters.w=1:2:2"])
    with pytest.raises(ValueError, match="starts must be at least 1, found 0"):
        diagram(starts=0)
    with pytest.raises(InputError, match="nothing dissipates"):
        linkages.attractor_diagram(linkages.load("pendulum"), "bars.rod.length=1:2:2", starts=2)
