"""Energy that contacts dissipate across and along their walls: what it is, and that it balances."""

import numpy as np
import pytest
from scipy.integrate import simpson

import linkages

BALL = """
joints: {{O: [0, 0]}}
bars: {{ball: {{joints: [O, P], length: 0.1, mass: 0.25, center: 0, inertia: 1e-4}}}}
free: {{ball: {{angle: 0, speed: {spin}}}}}
clearances: {{gap: {{joint: O, bar: ball, size: 1 mm, rate: [0.1, 0], {law}}}}}
"""
NAMES = ["clearance_normal_dissipation", "clearance_friction_dissipation"]
FORCES = ["clearance_force", "clearance_indentation_rate", "clearance_friction", "clearance_slip"]
WANTED = [*NAMES, "kinetic_energy", "potential_energy"]


def ball(law, *, end, spin=0.0, samples=5, outputs=WANTED, **options):
    text = BALL.format(law=law, spin=spin)
    return linkages.simulate(
        linkages.loads(text), end=end, samples=samples, outputs=outputs, **options
    ).data


@pytest.mark.parametrize("restitution", [0.5, 0.8, 1.0])
@pytest.mark.parametrize(
    "law",
    ["contact: restitution", "contact: exact, stiffness: 1e9"],
    ids=["rigid", "exact"],
)
def test_one_bounce_takes_its_part(law, restitution):
    """(1 − e²) m v²/2 across the wall, and nothing along one without friction."""
    data = ball(f"{law}, restitution: {restitution}", end=0.0115, rtol=1e-11)
    expected = 0.5 * 0.25 * 0.1**2 * (1 - restitution**2)
    # steps of 1e-11 of the energy of 1.25e-3 J; impacts of rigid bodies are round-off
    assert data[NAMES[0]][-1].item() == pytest.approx(expected, rel=1e-8, abs=1e-13)
    assert (data[NAMES[1]] == 0.0).all()
    assert (data[NAMES[0]][:3] == 0.0).all()  # in flight


@pytest.mark.parametrize(
    "law",
    [
        "contact: hunt-crossley-constant, stiffness: 1e9, dissipation: 1.5 s/m, pin_radius: 9 mm,"
        " friction: 0.2, slip: 10 mm/s",
        "contact: flores, stiffness: 1e9, restitution: 0.5, pin_radius: 9 mm, friction: 0.1,"
        " slip: 5 mm/s",
    ],
    ids=["hunt-crossley", "flores"],
)
def test_a_bounce_with_spin_against_quadrature(law):
    """What the elastic part stores it gives back: ∫ F d' dt and −∫ f w dt are lost."""
    data = ball(
        law, end=0.0125, spin=-5.0, samples=20001, outputs=[*WANTED, *FORCES], rtol=1e-11
    ).sel(clearance="gap")
    assert float(data.clearance_force[-1]) == 0.0
    assert float(data.clearance_force.max()) > 1.0
    time = data.time.to_numpy()
    across = simpson(data.clearance_force * data.clearance_indentation_rate, x=time)
    along = simpson(-data.clearance_friction * data.clearance_slip, x=time)
    found = [float(data[name][-1]) for name in NAMES]
    # Simpson's rule at samples of 0.6 µs, where the force has corners at the touch and the end
    assert found == pytest.approx([across, along], rel=2e-5)
    lost = float(data.kinetic_energy[0] - data.kinetic_energy[-1])
    assert sum(found) == pytest.approx(lost, rel=1e-9)
    assert min(found) > 1e-5


def energy_balance(data):
    """The largest energy that is neither there nor dissipated, over all energy."""
    energy = data.kinetic_energy + data.potential_energy
    lost = sum(data[name].sum("clearance") for name in NAMES)
    return float(abs(energy + lost - energy[0]).max() / abs(energy - energy.min()).max())


ENGINE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}
  rod: {joints: [A, B], length: 0.14, mass: 0.5, center: 0.07}
sliders: {piston: {joint: B, through: O, mass: 0.4, inertia: 1e-4}}
clearances:
  GAP
free: {crank: {angle: 0.3, speed: 40}}
assembly: {B: [0.18, 0]}
"""
SIZES = "size: 0.1 mm, pin_radius: 8 mm"
RUBS = "contact: restitution, restitution: 0.5, friction: 0.1"
GAPS = {
    "flores": f"gap: {{joint: B, bar: rod, {SIZES}, contact: flores, stiffness: 1e9,"
    " restitution: 0.5, friction: 0.1, slip: 10 mm/s}",
    "sticks": f"gap: {{joint: B, bar: rod, {SIZES}, contact: flores, stiffness: 1e9,"
    " restitution: 0.5, friction: 0.1, friction_law: coulomb}",
    "rigid": f"gap: {{joint: B, bar: rod, {SIZES}, {RUBS}}}",
    "two": f"gap: {{joint: B, bar: rod, {SIZES}, {RUBS}}}\n"
    f"  other: {{joint: A, bar: rod, {SIZES}, {RUBS}}}",
    "link beside": f"gap: {{joint: B, bar: rod, {SIZES}, {RUBS}}}\n"
    "  link: {joint: A, bar: rod, size: 0.1 mm, angle: 180 deg}",
    "film": f"gap: {{joint: B, bar: rod, {SIZES}, contact: lubricated, viscosity: 0.04,"
    " width: 12 mm, offset: [20 um, 0]}",
    "block": f"play: {{slider: piston, size: 0.1 mm, length: 50 mm, height: 30 mm, {RUBS}}}",
}


@pytest.mark.slow_except("flores", "sticks", "rigid", "film")
@pytest.mark.parametrize("gap", GAPS.values(), ids=GAPS)
def test_energy_is_there_or_dissipated(gap):
    """Whatever law contacts follow, of a mechanism that nothing drives."""
    mechanism = linkages.loads(ENGINE.replace("GAP", gap))
    data = linkages.simulate(mechanism, end=0.04, samples=201, outputs=WANTED).data
    # a few thousand steps at 1e-10
    assert energy_balance(data) < 1e-8
    for name in NAMES:
        total = data[name].sum("clearance")
        assert float(total[-1]) > 0.0
        assert (np.diff(total) >= -1e-9 * float(total[-1])).all()
    if "link" in data.clearance:
        assert (data[NAMES[0]].sel(clearance="link") == 0.0).all()


def test_impacts_are_the_sum_of_both_and_stops_have_their_own():
    """Of rigid bodies only friction between impacts comes to what they lose."""
    text = ENGINE.replace("GAP", GAPS["rigid"])
    text += "stops: [{slider: piston, lower: 0.16, restitution: 0.6}]\n"
    outputs = [*WANTED, "impact_loss", "clearance_friction_loss"]
    data = linkages.simulate(linkages.loads(text), end=0.04, samples=20001, outputs=outputs).data
    stop = data.impact_loss.sel(contact="stops[0].lower")
    assert float(stop[-1]) > 0.0
    pin = data.impact_loss.sel(contact="gap")[-1].item()
    power = data.clearance_friction_loss.sel(clearance="gap")
    slipping = power.integrate("time").item()
    found = sum(data[name].sel(clearance="gap")[-1].item() for name in NAMES)
    # the trapezoidal rule across two large jumps of the power errs by half a step of each
    assert found == pytest.approx(pin + slipping, abs=2e-6 * float(power.max()))
    energy = data.kinetic_energy + data.potential_energy
    lost = sum(data[name].sum("clearance") for name in NAMES) + stop
    assert float(abs(energy + lost - energy[0]).max()) < 1e-9 * float(energy.max())


def test_what_is_not_asked_for_is_not_integrated():
    """Steps are those of the motion alone, and driven mechanisms have no such output."""
    mechanism = linkages.loads(ENGINE.replace("GAP", GAPS["flores"]))
    short = {"end": 1e-3, "samples": 3}
    assert linkages.simulate(mechanism, **short).motion.losses is None
    asked = linkages.simulate(mechanism, **short, outputs=NAMES[:1])
    assert asked.motion.losses is not None
    assert asked.motion.losses.shape == (2, 3)
    ideal = linkages.loads(ENGINE.replace("clearances:\n  GAP\n", ""))
    with pytest.raises(ValueError, match="has no clearance_normal_dissipation"):
        linkages.simulate(ideal, **short, outputs=NAMES)
