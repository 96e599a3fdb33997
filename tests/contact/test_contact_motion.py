"""Clearances that open in whole motions: what holds of any of them, whatever the numbers are."""

import numpy as np
import pytest
from shared_definitions import loaded_engine

import linkages
from linkages.solution.plan import kernel_source
from linkages.topology.topology import build_topology

CONTACT = (
    ", contact: hunt-crossley-constant, stiffness: 2e9 N/m^1.5, dissipation: 1.5 s/m,"
    " carries: hole, pin_radius: 8 mm, friction: 0.05, slip: 10 mm/s"
)
FLORES = (
    "  end: {joint: B, bar: rod, size: 0.05 mm, contact: flores, stiffness: 1e9, restitution: 0.5,"
    " carries: pin, pin_radius: 6 mm, friction: 0.1, slip: 20 mm/s, offset: [10 um, 0]}"
)
LINK = "  end: {joint: B, bar: rod, size: 0.05 mm, angle: 180 deg}"


def engine(contact=CONTACT, end=""):
    return linkages.loads(
        loaded_engine(f"""\
clearances:
  gap: {{joint: A, bar: rod, size: 0.1 mm{contact}}}
{end}
drives: {{crank: {{angle: 0, speed: 600 rpm}}}}
simulate: {{end: 0.02, samples: 81}}
""")
    )


@pytest.fixture(scope="module")
def solution():
    return linkages.simulate(engine(), outputs="all")


def test_reactions_are_the_forces_of_the_contact(solution):
    """Newton's and Euler's equations of every body share no formula with the kernel."""
    data = solution.data
    gap = data.sel(clearance="gap")
    offset = gap.clearance_offset.to_numpy()
    normal = offset / np.linalg.norm(offset, axis=1)[:, None].clip(1e-30)
    along = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    # on the rod, which has the hole: the pin pulls it back, and drags it along
    force, friction = gap.clearance_force.to_numpy(), gap.clearance_friction.to_numpy()
    expected = friction[:, None] * along - force[:, None] * normal
    found = -data.joint_reaction.sel(joint="A.gap").to_numpy()
    # accelerations of a stiff contact are differences of forces: round-off of 400 N
    np.testing.assert_allclose(found, expected, atol=1e-9 * float(force.max()))
    assert np.abs(friction).max() > 1.0


def test_a_start_within_the_wall_is_told():
    found = linkages.simulate(engine(f"{CONTACT}, offset: [0.11 mm, 0]"), end=1e-4)
    assert any("gap starts pressed in by 1e-05 m" in note for note in found.notes)


@pytest.mark.parametrize(
    ("law", "told"),
    [("lankarani-nikravesh, restitution: 0.9", True), ("hertz", False)],
    ids=["with memory", "without"],
)
def test_a_start_in_contact_says_that_no_state_remembers_the_touch(law, told):
    contact = f", contact: {law}, stiffness: 2e9 N/m^1.5, offset: [0.11 mm, 0]"
    found = linkages.simulate(engine(contact), end=1e-4)
    assert any("no state says how fast it was touched" in note for note in found.notes) == told
    away = linkages.simulate(engine(contact.replace("0.11", "0.09")), end=1e-3)
    assert not any("no state says" in note for note in away.notes)


def test_energy_is_balanced(solution):
    energy = solution.data.kinetic_energy + solution.data.potential_energy
    # errors of 50 steps at the default tolerance of 1e-10
    assert float(abs(solution.data.energy_residual).max()) < 1e-9 * float(abs(energy).max())


def test_states_and_notes_tell_contact_from_flight(solution):
    gap = solution.data.sel(clearance="gap")
    state = gap.clearance_state.to_numpy()
    assert state.dtype == np.int8
    np.testing.assert_array_equal(state == 0, gap.clearance_indentation.to_numpy() < 0)
    assert gap.clearance_state.attrs["flag_meanings"] == "free impact following"
    touches = solution.motion.changes["gap: touch"]
    (note,) = [n for n in solution.notes if "touch" in n]
    assert note.startswith(f"clearance gap: {int(touches.rises.sum())} touches at ")


@pytest.mark.slow_except("two-contacts")
@pytest.mark.parametrize("end", [FLORES, LINK], ids=["two-contacts", "contact-and-link"])
def test_two_clearances(end):
    solution = linkages.simulate(engine(end=end), outputs="all", end=0.005)
    data = solution.data
    assert [str(name) for name in data["clearance"].to_numpy()] == ["gap", "end"]
    assert solution.system.topology.mobility == (5 if end == FLORES else 4)
    energy = data.kinetic_energy + data.potential_energy
    assert float(abs(data.energy_residual).max()) < 1e-9 * float(abs(energy).max())
    offset = np.linalg.norm(data.clearance_offset.sel(clearance="end"), axis=1)
    if end == LINK:  # a link has an offset, too, of its size
        np.testing.assert_allclose(offset, 5e-5, rtol=1e-9)  # 17 digits of a length of 0.14 m
        assert (data.clearance_state.sel(clearance="end") == 2).all()
    else:
        assert offset.min() < 4e-5
        assert set(solution.motion.changes) >= {"gap: touch", "end: touch", "end: press"}


def test_a_link_stays_what_it_is():
    """A clearance without the word has one free angle, and none of the new outputs."""
    closed = linkages.simulate(engine(contact=""), end=0.001)
    assert closed.system.topology.free == ("gap",)
    assert "clearance_offset" not in closed.data
    assert not closed.motion.changes


def test_numbers_are_arguments_of_the_kernel():
    """Other sizes, stiffnesses and restitutions have the same text."""
    flores = ", contact: flores, stiffness: 1e9, restitution: 0.5"
    exact = ", contact: exact, stiffness: 3e9, restitution: 0.9, offset: [1e-5, 0]"
    texts = {
        kernel_source(build_topology(engine(contact))).program.text for contact in (flores, exact)
    }
    assert len(texts) == 1


def test_another_state_goes_on_from_there(solution):
    data = solution.data
    half = data.isel(time=40)
    state = {
        f"gap.{axis}": (
            float(half.clearance_offset.sel(clearance="gap", axis=axis)),
            float(half.clearance_offset_rate.sel(clearance="gap", axis=axis)),
        )
        for axis in "xy"
    }
    times = data["time"].to_numpy()[40:]
    found = linkages.simulate(engine(), times=times, state=state)
    # both motions are within some 1e-10 of their sizes
    for name in ("clearance_offset", "slider_position"):
        expected = data[name].isel(time=slice(40, None))
        scale = float(abs(expected).max())
        np.testing.assert_allclose(found.data[name], expected, atol=1e-7 * scale)


def test_notes_take_the_numbers_of_their_own_mechanism(solution):
    """Equal structures share equations; a softer pin of another size shares no number."""
    softer = engine().with_values({"clearances.gap.size": 2e-4, "clearances.gap.stiffness": 1e7})
    for found, size in ((linkages.simulate(softer, outputs="all"), 2e-4), (solution, 1e-4)):
        deepest = float(found.data.clearance_indentation.max())
        (note,) = [note for note in found.notes if "indentation reaches" in note]
        told = float(note.split("%")[0].rsplit(" ", 1)[1]) / 100
        # the summary looks at the same samples and rounds to a per cent
        assert told == pytest.approx(deepest / size, abs=0.006)


@pytest.mark.parametrize("width", [5e-3, 50e-3])
def test_a_contact_that_reaches_far_around_the_pin_is_told(width):
    """2 √(F/(π E* L c)) of the largest force, with E* of two plastics of 3 GPa and 0.4."""
    keys = f"modulus: 3 GPa, poisson: 0.4, width: {width}, pin_radius: 8 mm, dissipation: 1.5 s/m"
    found = linkages.simulate(engine(f", contact: hunt-crossley-constant, {keys}"))
    force = float(found.data.clearance_force.max())
    plane = 3e9 / (2 * (1 - 0.4**2))
    half = np.degrees(2 * np.sqrt(force / (np.pi * plane * width * 1e-4)))
    told = [note for note in found.notes if "to either side" in note]
    assert (half > 20) == (width == 5e-3) == bool(told)
    assert all(f"reaches {half:.0f}° to either side" in note for note in told)


def test_energy_is_balanced_with_the_stiffness_of_cylinders():
    """Its exponent is no multiple of one half, so that powers go through logarithms."""
    keys = "modulus: 3 GPa, stiffness_model: cylinder, width: 15 mm, dissipation: 1.5 s/m"
    found = linkages.simulate(engine(f", contact: hunt-crossley-constant, {keys}"), outputs="all")
    data = found.data
    assert float(data.clearance_force.max()) > 100.0
    energy = data.kinetic_energy + data.potential_energy
    assert float(abs(data.energy_residual).max()) < 1e-9 * float(abs(energy).max())
