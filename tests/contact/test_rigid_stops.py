"""Stops by restitution: bounces, accumulation and rest in closed form, and what impacts lose."""

import numpy as np
import pytest
from tangent_differences import differences

import linkages
from linkages.errors import InputError

G = 9.81
BALL = f"""
gravity: [0, -{G}]
joints: {{O: [0, 0]}}
sliders: {{ball: {{joint: P, through: O, angle: 90 deg, mass: 0.3}}}}
free: {{ball: {{position: 1, speed: 0}}}}
stops: [{{slider: ball, lower: 0, restitution: 0.7}}]
"""
CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {cart: {position: 0, speed: 3}}
stops:
"""
ARM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 0.5, mass: 1.2}}
free: {arm: {angle: 60 deg, speed: 0}}
stops: [{bars: [ground, arm], lower: -30 deg, upper: 90 deg, restitution: 0.6}]
"""


def test_a_ball_bounces_and_comes_to_rest():
    """Times t₁(1 + 2e + 2e² + …), which accumulate at t₁(1 + e)/(1 − e); then it rests."""
    e, first = 0.7, np.sqrt(2 / G)
    solution = linkages.simulate(linkages.loads(BALL), end=4.0, samples=401, outputs="all")
    data, touches = solution.data, solution.motion.changes["stops[0].lower: touch"].time
    expected = first * (1 + 2 * np.cumsum([0, *(e ** np.arange(1, len(touches)))]))
    # parabolas are exact for every method of order 2 and more: round-off of 24 bounces
    assert touches == pytest.approx(expected, abs=1e-13)
    end = first * (1 + e) / (1 - e)
    # no bounce slower than the least rate, 1 mm/s, is left
    assert end - 2 * 1e-3 / G / (1 - e) < touches[-1] < end
    rest = data.isel(time=data.time > end)
    assert abs(rest.slider_position).max() < 1e-10  # the tolerance
    np.testing.assert_allclose(rest.stop_force, 0.3 * G, rtol=1e-8)
    # all of it is lost: 0.3·9.81·1 J, in one coordinate without drives by Kelvin's formula too
    assert float(data.impact_loss[-1, 0]) == pytest.approx(0.3 * G, rel=1e-12)
    assert abs(data.energy_residual).max() < 1e-10 * 0.3 * G
    assert "stop stops[0].lower: 24 touches at 0.00121 to 4.43 m/s" in solution.notes[0]


def test_each_impact_loses_its_share():
    """(1 − e²) m v²/2 at v, e v, e² v, …"""
    entry = "- {slider: cart, lower: -1, upper: 1, restitution: 0.5}\n"
    data = linkages.simulate(linkages.loads(CART + entry), end=3.0, samples=31, outputs="all").data
    hits = np.cumsum([1 / 3, 2 / 1.5, 2 / 0.75])
    kinetic = 9.0 * 0.25 ** np.searchsorted(hits, data.time.to_numpy())
    np.testing.assert_allclose(data.kinetic_energy, kinetic, rtol=1e-12)
    np.testing.assert_allclose(9.0 - data.impact_loss.sum("contact"), kinetic, rtol=1e-12)
    lower = data.impact_loss.sel(contact="stops[0].lower").to_numpy()
    assert lower[-1] == pytest.approx(9.0 * 0.25 * 0.75, rel=1e-12)


def test_nothing_is_lost_between_elastic_stops():
    entry = "- {slider: cart, lower: -1, upper: 1, restitution: 1}\n"
    data = linkages.simulate(linkages.loads(CART + entry), end=10.1, samples=5, outputs="all").data
    np.testing.assert_allclose(abs(data.slider_velocity), 3.0, rtol=1e-13)
    turned = (3 * data.time.to_numpy() + 1) % 4
    expected = np.where(turned < 2, turned - 1, 3 - turned)
    np.testing.assert_allclose(data.slider_position[:, 0], expected, atol=1e-12)


def test_an_arm_rests_on_its_stop_and_is_pulled_off():
    """A torque that grows lifts it off where it exceeds the weight's, m g l/2 cos 30°."""
    lift = "loads: [{bar: arm, torque: 0.5*t}]\n"
    solution = linkages.simulate(
        linkages.loads(ARM + lift), end=20.0, samples=2001, outputs="all", max_steps=10**6
    )
    data, touches = solution.data, solution.motion.changes["stops[0].lower: touch"]
    off = 1.2 * G * 0.25 * np.cos(np.pi / 6) / 0.5
    pressed = solution.motion.changes["stops[0].lower: press"].time
    # errors of steps leave the arm where it rests to 1e-10 rad
    assert pressed[-1] == pytest.approx(off, abs=1e-9)
    assert not touches.rises[touches.time > off].any()
    resting = data.stop_torque[:, 0].to_numpy()
    late = (data.time > 4.0) & (data.time < off)
    np.testing.assert_allclose(resting[late], 0.5 * (off - data.time[late]), atol=1e-8)
    # the ground gives what weight and torque leave, through the joint
    still = data.joint_reaction.sel(joint="O", axis="y").to_numpy()[late]
    np.testing.assert_allclose(still, 1.2 * G, rtol=1e-7)
    assert abs(data.energy_residual).max() < 1e-8 * abs(data.potential_energy).max()


def test_a_rope_gets_taut_at_once():
    """A mass on a circle: it falls freely, loses its radial speed, and swings at once."""
    text = f"""
gravity: [0, -{G}]
joints: {{O: [0, 0]}}
sliders:
  across: {{joint: A, through: O}}
  mass: {{joint: M, on: across, angle: 90 deg, mass: 2}}
free: {{across: {{position: 0.6, speed: 0}}, mass: {{position: 0, speed: 0}}}}
stops: [{{between: [O, M], upper: 1, restitution: 0}}]
"""
    data = linkages.simulate(linkages.loads(text), end=1.0, samples=1001, outputs="all").data
    place = data.joint_position.sel(joint="M").to_numpy()
    taut = np.sqrt(2 * 0.8 / G)
    after = data.time.to_numpy() > taut
    # errors of steps at 1e-10
    assert np.hypot(*place[after].T) == pytest.approx(1.0, abs=1e-9)
    speed = G * taut
    lost = 0.5 * 2 * (0.8 * speed) ** 2
    assert float(data.impact_loss[-1, 0]) == pytest.approx(lost, rel=1e-10)
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy[after] == pytest.approx(-lost, abs=1e-8)
    # tension: weight along the rope and m v²/r
    rate = data.joint_velocity.sel(joint="M").to_numpy()[after]
    expected = 2 * ((rate**2).sum(1) - G * place[after, 1])
    np.testing.assert_allclose(data.stop_force[after, 0], expected, rtol=1e-7)


# A particle between bounces on a floor, under a force −m g (1 + a cos(2πt/T)).
E, PERIOD, SHARE = 0.8, 0.5, 0.6
SHAKEN = f"""
gravity: [0, -{G}]
joints: {{O: [0, 0]}}
sliders: {{ball: {{joint: P, through: O, angle: 90 deg, mass: 1}}}}
drives: {{phase: {{angle: 0, speed: {2 * np.pi / PERIOD!r}}}}}
bars: {{phase: {{joints: [O, Q], length: 0.1, mass: 0}}}}
loads: [{{slider: ball, force: {-G * SHARE!r}*cos({2 * np.pi / PERIOD!r}*t)}}]
stops: [{{slider: ball, lower: 0, restitution: {E}, least_rate: 1e-6 m/s}}]
"""


def orbit():
    """Phase and speed behind impacts of the motion that bounces once a period.

    v⁻ = v⁺ − gT and v⁺ = −e v⁻; x is zero again: v⁺ − gT/2 + (g a/ω) sin ωt₀ = 0.
    """
    omega = 2 * np.pi / PERIOD
    speed = G * PERIOD * E / (1 + E)
    sine = (0.5 * G * PERIOD - speed) * omega / (G * SHARE)
    return np.arcsin(sine) / omega, speed, omega


def multipliers(time):
    """Of the map of (time, speed) from one impact to the next, by implicit differentiation.

    x(t) = v s − g s²/2 + (g a/ω²)(cos ωt − cos ωt₀ + ω s sin ωt₀), s = t − t₀.
    """
    _, speed, omega = orbit()
    period, amount = PERIOD, G * SHARE
    cosine = np.cos(omega * time)
    before = -speed / E
    by_start = -speed + (G + amount * cosine) * period
    later = -by_start / before, -period / before
    # v(t) = v − g s − (g a/ω)(sin ωt − sin ωt₀)
    push = -G - amount * cosine
    rate_by_start = G + amount * cosine
    matrix = np.array(
        [
            [later[0], later[1]],
            [-E * (rate_by_start + push * later[0]), -E * (1 + push * later[1])],
        ]
    )
    return np.linalg.eigvals(matrix)


def test_exponents_of_an_impact_oscillator():
    """Multipliers of an orbit with one bounce a period, by hand; their product is e²."""
    time, speed, _ = orbit()
    found = None
    for start in (time, PERIOD / 2 - time):
        values = multipliers(start)
        assert np.prod(values).real == pytest.approx(E**2, rel=1e-12)
        if np.abs(values).max() < 1:
            found = start, np.sort(np.log(np.abs(values)))[::-1] / PERIOD
    assert found is not None
    start, expected = found
    # half a period behind the impact
    start, half = float(start), PERIOD / 2
    omega = 2 * np.pi / PERIOD
    ahead = start + half
    amount = G * SHARE
    x = speed * half - G * half**2 / 2
    x += (
        amount
        / omega**2
        * (np.cos(omega * ahead) - np.cos(omega * start) + omega * half * np.sin(omega * start))
    )
    v = speed - G * half - amount / omega * (np.sin(omega * ahead) - np.sin(omega * start))
    text = SHAKEN.replace("*t)", f"*(t + {ahead!r}))")
    free = f"free: {{ball: {{position: {float(x)!r}, speed: {float(v)!r}}}}}\n"
    mechanism = linkages.loads(text + free)
    data = linkages.lyapunov(mechanism, periods=64)
    # 64 periods on the orbit: errors of steps of 1e-10, and ln 10 / 32 s for directions
    assert data.exponent.to_numpy().sum() == pytest.approx(expected.sum(), rel=1e-8)
    assert data.exponent.to_numpy() == pytest.approx(expected, abs=0.05)
    assert data.attrs["lost"] == 0
    assert data.attrs["least_touch"] == pytest.approx(speed / E, rel=1e-6)


def test_the_slowest_touch_is_one_of_those_that_count():
    """An oscillator that begins slowly and soon hits its wall at one rate in each period."""
    text = """
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
springs: [{slider: m, stiffness: 1}]
loads: [{slider: m, force: "2*cos(2.8*t)"}]
stops: [{slider: m, upper: 0, restitution: 0.5}]
free: {m: {position: -0.1}}
"""
    mechanism = linkages.loads(text)
    whole = linkages.lyapunov(mechanism, periods=100)
    later = linkages.lyapunov(mechanism, periods=20, skip=80)
    assert later.attrs["least_touch_time"] > 80 * 2 * np.pi / 2.8
    changes = linkages.simulate(mechanism, end=100 * 2 * np.pi / 2.8).motion.changes
    (piece,) = changes["stops[0].upper: touch"].pieces
    rates = piece.state[1]
    counted = rates[piece.time > 80 * 2 * np.pi / 2.8]
    assert whole.attrs["least_touch"] == pytest.approx(rates.min(), rel=1e-6)
    assert later.attrs["least_touch"] == pytest.approx(counted.min(), rel=1e-6)
    assert rates.min() < 0.9 * counted.min()


def test_tangents_through_bounces():
    found, expected = differences(BALL, 1.9, 1.0)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_a_ball_at_rest_leaves_no_neighbours():
    """Both exponents are −∞, and the verdict on the motion is rest."""
    data = linkages.lyapunov(linkages.loads(BALL + "simulate: {end: 0.1}\n"), periods=64)
    assert data.sizes["index"] == 0
    assert data.attrs["lost"] == 2
    assert data.attrs["settled"] == 1
    report = linkages.verdict(linkages.loads(BALL + "simulate: {end: 0.1}\n"), periods=200, skip=0)
    assert report.verdict == "at rest"
    assert "all Lyapunov exponents are −∞" in report.reasons[0]


def test_time_goes_on_exactly_through_many_bounces():
    """A cart between two walls: times are compensated, so that late ones are right as well.

    At 10⁶ s they are rounded to 10⁻¹⁰ s. Errors of 11,000 bounces, each of them located to a
    hundredth of this, would amount to 10⁻⁸ s if what is rounded were forgotten at each.
    """
    stops = "- {slider: cart, lower: -0.5, upper: 0.5, restitution: 1}\n"
    flow = linkages.compile(linkages.loads(CART + stops)).flow(max_steps=10**6)
    speed, start, span = 1.375, 1e6, 8000.3
    found = flow.advance([0.0, speed], start, start + span).y
    way = (speed * ((start + span) - start) + 0.5) % 2.0  # a triangle wave of period 2
    assert found[0] == pytest.approx(abs(1.0 - way) * -1.0 + 0.5, abs=1e-9)


def test_a_driven_slider_does_not_bounce():
    driven = "drives: {cart: {position: 0, speed: 1}}"
    text = CART.replace("free: {cart: {position: 0, speed: 3}}", driven)
    with pytest.raises(InputError, match="nothing moves freely, so nothing bounces"):
        linkages.simulate(
            linkages.loads(text + "- {slider: cart, upper: 1, restitution: 1}\n"), end=1
        )


def test_a_rigid_stop_has_no_equations_in_closed_form():
    from linkages.equations import derive
    from linkages.topology.topology import build_topology

    with pytest.raises(InputError, match=r"stops\[0\].restitution.* impacts change rates at once"):
        derive(build_topology(linkages.loads(BALL)))


def test_sections_sweeps_and_files(tmp_path):
    """Sections, sweeps of a restitution and files of exponents take rigid stops."""
    mechanism = linkages.loads(SHAKEN + "free: {ball: {position: 0.3, speed: 0}}\n")
    data = linkages.lyapunov(mechanism, periods=64)
    data.to_netcdf(tmp_path / "found.nc", engine="h5netcdf")
    found = linkages.bifurcation(
        mechanism, {"stops.0.restitution": [0.3, 0.5]}, periods=40, skip=60
    )
    speed = found.slider_velocity.isel(start=0).to_numpy()
    # at rest, or in another motion of one period: points repeat
    assert np.ptp(speed, axis=-2).max() < 1e-6
