"""Rigid contact: impacts that accumulate, then the massless link; what stiff contact tends to."""

import numpy as np
import pytest
from contact_references import Reference, content, off

import linkages

NAME = "7-rigid-pin-in-hole"
SIZE, GRAVITY = 0.2e-3, 9.81
STIFF = content(NAME)["extra"]["stiff_limit"]["rows"]


def test_states_through_chatter_into_following_contact():
    reference = Reference(NAME)
    outputs = ["clearance_offset", "clearance_offset_rate", "clearance_force"]
    data = linkages.simulate(
        linkages.loads(reference.definition), times=[0.0, *reference.times], rtol=1e-11,
        outputs=outputs,
    ).data.isel(time=slice(1, None))  # fmt: skip
    assert off(data.clearance_offset[:, 0].to_numpy(), reference.offset).max() < 1e-8
    assert off(data.clearance_offset_rate[:, 0].to_numpy(), reference.rate).max() < 1e-8
    force = reference.column("gap.force")
    assert off(data.clearance_force.to_numpy(), force).max() < 1e-8
    rho = np.hypot(*data.clearance_offset[:, 0].to_numpy().T)
    closed = np.array([state["gap.state"] == "closed" for state in reference.states])
    assert rho[closed] == pytest.approx(SIZE, rel=1e-12)


def rigid_offset(time):
    """Between the impacts of the reference a pin falls freely."""
    reference = Reference(NAME)
    last = int(np.flatnonzero(reference.times <= time)[-1])
    later = time - reference.times[last]
    assert not any(reference.times[last] < float(e["t"]) < time for e in reference.events)
    fall = reference.offset[last] + reference.rate[last] * later
    return fall - [0.0, 0.5 * GRAVITY * later**2]


def test_stiff_contact_tends_to_rigid_contact():
    """With the law that bounces exactly, like the duration of a contact: K^(-2/5)."""
    distances = []
    for row in STIFF[1:4]:
        law = f"contact: exact, stiffness: {row['stiffness']} N/m^1.5"
        definition = Reference(NAME).definition.replace("contact: restitution", law)
        mechanism = linkages.loads(definition)
        times = sorted(map(float, row["distance_of_offset_at_t"]))
        data = linkages.simulate(
            mechanism, times=[0.0, *times], rtol=1e-11, outputs=["clearance_offset"]
        ).data
        found = [
            np.hypot(*(data.clearance_offset[k + 1, 0].to_numpy() - rigid_offset(time)))
            for k, time in enumerate(times)
        ]
        expected = list(map(float, row["distance_of_offset_at_t"].values()))
        assert found == pytest.approx(expected, rel=1e-4)  # six digits are given
        distances.append(found[0])
    ratios = np.array(distances[:-1]) / distances[1:]
    assert ratios == pytest.approx(100**0.4, abs=0.3)
