"""Equilibria and frequencies against closed forms, and against programs of these tests."""

import json

import numpy as np
import pytest
from resting_mechanisms import BALANCER, FOUR_BAR, FRICTION, SERIES, TRUSS, G, chain
from scipy.optimize import brentq
from scipy.special import roots_laguerre

import linkages
from linkages import equilibrium


def frequencies(data, k=1):
    values = data["frequency"].sel(equilibrium=k).to_numpy()
    return np.sort(values[np.isfinite(values)])


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_a_hanging_chain_has_the_zeros_of_laguerre_polynomials(count):
    """ω²·L/g are the zeros of L_n; there are 2^n equilibria, of which the hanging one is stable."""
    data = equilibrium(linkages.loads(chain(count)), starts=300)
    assert data.sizes["equilibrium"] <= 2**count
    if count < 4:
        assert data.sizes["equilibrium"] == 2**count
    assert data["stable"].to_numpy().tolist() == [1] + [0] * (data.sizes["equilibrium"] - 1)
    expected = np.sqrt(G * roots_laguerre(count)[0]) / (2 * np.pi)
    assert frequencies(data) == pytest.approx(expected, rel=1e-13)


def truss_load(y, k=1000.0, rest=1.2):
    """Load down that holds the apex at a height."""
    return 2 * k * y * (rest / np.hypot(1.0, y) - 1.0)


def test_a_truss_rests_where_its_closed_form_does():
    data = equilibrium(linkages.loads(TRUSS))
    grid = np.linspace(-1.5, 1.5, 400)
    over = truss_load(grid) - 10.0
    places = [
        brentq(lambda y: truss_load(y) - 10.0, *grid[[k, k + 1]], xtol=1e-15)
        for k in np.flatnonzero(over[1:] * over[:-1] < 0)
    ]
    found = data["state"].sel(coordinate="apex.position").to_numpy()
    assert np.sort(found) == pytest.approx(np.sort(places), rel=1e-12)
    # K = 2k(1 − L0 b²/(b² + y²)^1.5)
    stiffness = 2000 * (1 - 1.2 / (1 + found**2) ** 1.5)
    assert data["stable"].to_numpy().tolist() == (stiffness > 0).astype(int).tolist()
    for k, own in enumerate(stiffness, 1):
        values = data["eigenvalue"].sel(equilibrium=k).to_numpy() @ [1, 1j]
        values = values[np.isfinite(values)]
        assert values**2 == pytest.approx(-own / 2.0, rel=1e-12)
    energy = 1000 * (np.hypot(1, found) - 1.2) ** 2  # the load is no potential
    assert data["potential_energy"].to_numpy() == pytest.approx(energy, rel=1e-12)


def test_a_truss_snaps_at_the_load_of_the_closed_form():
    """Folds lie where (b² + y²)^1.5 = L0 b²; there the equilibrium is neutral."""
    fold = np.sqrt(1.2 ** (2 / 3) - 1)
    state, paths = {"apex.position": float(fold)}, ["loads[0].force"]
    data = equilibrium(linkages.loads(TRUSS), solve=paths, state=state)
    (load,) = json.loads(data.attrs["solved"]).values()
    assert -load == pytest.approx(truss_load(fold), rel=1e-13)
    near = int(np.abs(data["state"].to_numpy()[:, 0] - fold).argmin())
    assert data["state"][near, 0] == pytest.approx(fold, abs=1e-7)  # a double root
    assert not data["stable"][near]
    # under more than the load of the fold only the position below is left
    over = linkages.loads(TRUSS).with_values({"loads[0].force": 1.01 * load})
    assert equilibrium(over).sizes["equilibrium"] == 1


def test_a_compound_pendulum():
    """ω² = m g d/(J + m d²)."""
    text = """
    gravity: [0, -9.81]
    joints: {O: [0, 0]}
    bars: {rod: {joints: [O, P], length: 1, mass: 3, center: [0.37, 0.05], inertia: 0.21}}
    dampers: [{joint: O, damping: 0.4}]
    free: {rod: {angle: 0.3, speed: 0}}
    """
    data = equilibrium(linkages.loads(text))
    arm = np.hypot(0.37, 0.05)
    inertia = 0.21 + 3 * arm**2
    omega, rate = np.sqrt(3 * 9.81 * arm / inertia), 0.4 / inertia
    assert frequencies(data) == pytest.approx([omega / (2 * np.pi)], rel=1e-13)
    assert data["damping_ratio"].sel(equilibrium=1)[0] == pytest.approx(
        rate / (2 * omega), rel=1e-12
    )
    assert data["mode_kind"].sel(equilibrium=1)[0] == "damped"
    assert data["state"].sel(equilibrium=1)[0] == pytest.approx(
        -np.pi / 2 - np.arctan2(0.05, 0.37), abs=1e-14
    )
    assert data["joint_reaction"].sel(equilibrium=1, joint="O").to_numpy() == pytest.approx(
        [0.0, 3 * 9.81], abs=1e-12
    )


class FourBar:
    """A four-bar with its energies as functions of the crank's angle, by complex numbers."""

    def __init__(self, a, b, c, spring, side):
        self.lengths, self.spring, self.side = (a, b, c), spring, side

    def places(self, angle):
        """Joints A and B as pairs, analytic in the angle."""
        a, b, c = self.lengths
        first = np.array([a * np.cos(angle), a * np.sin(angle)])
        across = np.array([0.4, 0.0]) - first
        square = across @ across
        along = (b**2 - c**2 + square) / (2 * square)
        height = self.side * np.sqrt(b**2 / square - along**2)
        second = first + along * across + height * np.array([-across[1], across[0]])
        return first, second

    def potential(self, angle):
        first, second = self.places(angle)
        ground = np.array([0.4, 0.0])
        weight = 9.81 * (0.5 * first[1] + 2 * 0.5 * (first[1] + second[1]) + 1.5 * 0.5 * second[1])
        result = weight
        for end, anchor, k, rest in (
            (first, ground, 200.0, 0.3), (second, np.array(self.spring), 90.0, 0.2)
        ):  # fmt: skip
            way = end - anchor
            result = result + 0.5 * k * (np.sqrt(way @ way) - rest) ** 2
        return result

    def slope(self, angle):
        return self.potential(angle + 1e-30j).imag / 1e-30

    def curvature(self, angle):
        """Second derivative: five points on exact first ones."""
        h = 1e-3
        weights = np.array([1, -8, 0, 8, -1]) / (12 * h)
        return sum(w * self.slope(angle + k * h) for k, w in enumerate(weights, -2))

    def inertia(self, angle):
        """Uniform bars: m/3 (v1² + v1·v2 + v2²) of each."""
        moved = self.places(angle + 1e-30j)
        first, second = (place.imag / 1e-30 for place in moved)
        zero = np.zeros(2)
        pairs = ((1.0, zero, first), (2.0, first, second), (1.5, zero, second))
        return sum(m / 3 * (u @ u + u @ v + v @ v) for m, u, v in pairs)


CASES = [(0.1, 0.35, 0.3, (0.1, 0.5), 60), (0.12, 0.33, 0.36, (0.5, -0.3), 200)]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_four_bar_on_springs_against_a_program_of_this_test(case):
    a, b, c, spring, angle = case
    text = FOUR_BAR.format(a=a, b=b, c=c, sx=spring[0], sy=spring[1])
    for side in (1, -1):
        own = FourBar(a, b, c, spring, side)
        place = own.places(np.radians(angle))[1]
        free = f"free: {{crank: {{angle: {angle} deg, speed: 0}}}}\n"
        data = equilibrium(linkages.loads(f"{text}{free}assembly: {{B: {place.tolist()}}}\n"))
        grid = np.linspace(-np.pi, np.pi, 2001)
        slopes = np.array([own.slope(x) for x in grid])
        rests = [
            brentq(own.slope, grid[k], grid[k + 1], xtol=1e-15)
            for k in np.flatnonzero(slopes[1:] * slopes[:-1] < 0)
        ]
        found = data["state"].sel(coordinate="crank.angle").to_numpy()
        assert np.sort(found) == pytest.approx(rests, abs=1e-11)
        for k, x in enumerate(found, 1):
            square = own.curvature(x) / own.inertia(x)
            values = data["eigenvalue"].sel(equilibrium=k).to_numpy() @ [1, 1j]
            assert values[0] ** 2 == pytest.approx(-square, rel=1e-8)  # five points: h⁴ = 1e-12
            assert bool(data["stable"].sel(equilibrium=k)) == (square > 0)
            joint = data["joint_position"].sel(equilibrium=k, joint="B").to_numpy()
            assert joint == pytest.approx(own.places(x)[1], abs=1e-11)


def test_equilibria_do_not_depend_on_the_free_coordinate_or_the_order():
    """The rocker comes back from its limits in the other branch of assembly."""
    text = FOUR_BAR.format(a=0.1, b=0.35, c=0.3, sx=0.1, sy=0.5)
    crank = "free: {crank: {angle: 60 deg, speed: 0}}\nassembly: {B: [0.35, 0.3]}\n"
    rocker = "free: {rocker: {angle: 115 deg, speed: 0}}\nassembly: {A: [0.05, 0.08]}\n"
    first = equilibrium(linkages.loads(text + crank))
    others = [
        equilibrium(linkages.loads(text + rocker)),
        equilibrium(linkages.loads(text + crank), starts=37, seed=5),
    ]
    for other in others:
        for name in ("joint_position", "eigenvalue", "potential_energy", "joint_reaction"):
            np.testing.assert_allclose(other[name], first[name], rtol=1e-10, atol=1e-12)


def test_a_parallelogram_is_followed_through_its_change_points():
    """From above both flat positions must be passed smoothly to find the hanging one."""
    data = equilibrium(linkages.load("n-four-bar"))
    assert data["state"].sel(coordinate="post0.angle").to_numpy() == pytest.approx(
        [-np.pi / 2, np.pi / 2], abs=1e-14
    )
    # three posts m/3 and two links m move, and as much hangs at half and the whole length
    expected = np.sqrt(9.81 * (3 * 0.5 + 2) / (3 / 3 + 2)) / (2 * np.pi)
    assert frequencies(data) == pytest.approx([expected], rel=1e-13)


def test_the_spring_of_a_balancer_is_found_and_holds_it_everywhere():
    """k·a·b = m·g·l without free length."""
    options = {"solve": ["springs[0].stiffness"], "state": ["arm.angle=0.3 rad"]}
    data = equilibrium(linkages.loads(BALANCER), **options)
    solved = json.loads(data.attrs["solved"])
    assert solved["springs[0].stiffness"] == pytest.approx(2 * G * 0.4 / (0.3 * 0.2), rel=1e-13)
    assert data.sizes["equilibrium"] == 1
    assert (int(data["neutral"][0]), int(data["stable"][0])) == (1, 0)
    assert data["state"][0, 0] == pytest.approx(0.3)
    assert "every position within reach is an equilibrium" in json.loads(data.attrs["notes"])
    assert set(data["mode_kind"].to_numpy().ravel()) == {"neutral"}


@pytest.mark.parametrize("damping", [0.0, 3.0], ids=["undamped", "damped"])
def test_a_massless_block_follows_without_delay_or_by_an_equation_of_first_order(damping):
    text = SERIES.replace("DAMPING", str(damping))
    data = equilibrium(linkages.loads(text))
    one = data.sel(equilibrium=1)
    assert one["state"].to_numpy()[:2] == pytest.approx([0.6, 1.3], abs=1e-13)
    if damping:  # 2 x'' + x' + 150 x − 50 y = 0, 3 y' + 100 y − 50 x = 0
        expected = np.roots(np.polysub(np.polymul([2, 1, 150], [3, 100]), [2500]))
    else:  # two springs of 50 in a row are one of 25
        expected = np.roots([2, 1, 125])
    values = one["eigenvalue"].to_numpy() @ [1, 1j]
    values = values[np.isfinite(values)]
    expected = expected[expected.imag >= 0]
    assert sorted(values, key=abs) == pytest.approx(sorted(expected, key=abs), rel=1e-12)
    names = [name for name in one["state_name"].to_numpy() if name]
    assert names == ["a.position", *(["b.position"] if damping else []), "a.velocity"]


def test_what_friction_holds_is_an_interval():
    """|m g l/2 cos θ| ≤ 2 N m."""
    data = equilibrium(linkages.loads(FRICTION))
    half = np.pi / 2 - np.arccos(2 / (3 * 9.81 * 0.5))
    expected = [[-np.pi / 2 - half, -np.pi / 2 + half], [np.pi / 2 - half, np.pi / 2 + half]]
    assert data["interval"].sel(coordinate="rod.angle").to_numpy() == pytest.approx(
        np.array(expected), abs=1e-13
    )
    assert data["stable"].to_numpy().tolist() == [1, 1]
    assert "dry friction holds it" in str(data["reason"][0].item())
    free = equilibrium(linkages.loads(FRICTION).with_values({"friction[0].torque": 0}))
    assert np.isnan(free["interval"]).all()
    assert free["stable"].to_numpy().tolist() == [1, 0]


def test_two_frictions_hold_a_set_with_known_extremes():
    """K q = f + F with |F1| ≤ 4, |F2| ≤ 3: extremes lie |K⁻¹| F from the middle."""
    text = """
    joints: {O: [0, 0]}
    sliders:
      a: {joint: A, through: O, angle: 0, mass: 2}
      b: {joint: B, through: O, angle: 0, mass: 1}
    springs:
      - {slider: a, stiffness: 100, position: 0.1}
      - {between: [A, B], stiffness: 50, length: 0.5}
    friction: [{slider: a, force: 4}, {slider: b, force: 3}]
    loads: [{slider: b, force: 10}]
    free: {a: {position: 0.2, speed: 0}, b: {position: 0.8, speed: 0}}
    """
    data = equilibrium(linkages.loads(text))
    stiffness = np.array([[150.0, -50.0], [-50.0, 50.0]])
    middle = np.linalg.solve(stiffness, [10 - 25, 25 + 10])
    wide = np.abs(np.linalg.inv(stiffness)) @ [4.0, 3.0]
    found = data.sel(equilibrium=1 + int(data["state"].to_numpy()[:, 1].argmax()))
    expected = np.stack([middle - wide, middle + wide], axis=1)
    assert found["interval"].to_numpy()[:2] == pytest.approx(expected, abs=1e-9)


def test_friction_holds_a_block_wherever_it_is_or_nowhere():
    text = """
    sliders: {block: {joint: P, through: [0, 0], mass: 2}}
    friction: [{slider: block, force: 20 N}]
    loads: [{slider: block, force: 12}]
    free: {block: {position: 0.3, speed: 0}}
    """
    data = equilibrium(linkages.loads(text))
    assert data["state"][0, 0] == pytest.approx(0.3)
    assert any("everywhere" in note for note in json.loads(data.attrs["notes"]))
    with pytest.raises(linkages.ComputationError, match="no equilibrium was found"):
        equilibrium(linkages.loads(text).with_values({"loads[0].force": 21}))


@pytest.mark.parametrize("stiffness", [1e3, 1e7, 1e11])
def test_a_bar_rests_on_an_elastic_stop_however_stiff(stiffness):
    """The torque m·g·l/2·cos θ deflects it by so much over k."""
    text = f"""
    gravity: [0, -9.81]
    joints: {{O: [0, 0]}}
    bars: {{rod: {{joints: [O, P], length: 1, mass: 1}}}}
    stops: [{{bars: [ground, rod], lower: -60 deg, stiffness: {stiffness} N*m/rad}}]
    free: {{rod: {{angle: 20 deg, speed: 0}}}}
    """
    data = equilibrium(linkages.loads(text))
    assert data["stable"].to_numpy().tolist() == [1, 0]
    angle = data["state"][0, 0].item()
    torque = 9.81 / 2 * np.cos(angle)
    assert -np.pi / 3 - angle == pytest.approx(torque / stiffness, rel=1e-6, abs=3e-16)
    hangs = 9.81 / 2 * np.sin(angle)  # which is negative: gravity pulls it on
    expected = np.sqrt((stiffness - hangs) * 3) / (2 * np.pi)
    assert frequencies(data)[0] == pytest.approx(expected, rel=1e-9)


def test_a_stop_holds_and_pushes():
    text = """
    gravity: [0, -9.81]
    joints: {O: [0, 0]}
    bars: {rod: {joints: [O, P], length: 1, mass: 3, inertia: 0}}
    stops: [{bars: [ground, rod], lower: -60 deg, upper: 200 deg, restitution: 0.5}]
    free: {rod: {angle: 70 deg, speed: 0}}
    """
    data = equilibrium(linkages.loads(text))
    angles = np.degrees(data["state"].sel(coordinate="rod.angle").to_numpy())
    assert np.sort(angles) == pytest.approx([-60, 90, 200], abs=1e-10)
    held = np.abs(angles - 90) > 1
    assert data["stable"].to_numpy().tolist() == held.astype(int).tolist()
    # reactions carry the weight, whatever torque the stop has
    assert data["joint_reaction"].sel(joint="O").to_numpy() == pytest.approx(
        np.tile([0, 3 * 9.81], (3, 1)), abs=1e-11
    )


def test_a_bar_that_hangs_in_a_rigid_bearing():
    """The journal is at the bottom; friction holds it within the angle of friction."""
    text = """
    gravity: [0, -9.81]
    joints: {O: [0, 0]}
    bars: {rod: {joints: [O, P], length: 0.5, mass: 2}}
    clearances:
      gap: {joint: O, bar: rod, size: 1 mm, contact: restitution, restitution: 0.5,
            offset: [0, -0.5 mm]}
    free: {rod: {angle: -80 deg, speed: 0}}
    """
    data = equilibrium(linkages.loads(text))
    assert data["stable"].to_numpy().tolist() == [1, 0]
    one = data.sel(equilibrium=1)
    assert one["state"].to_numpy()[:3] == pytest.approx([-np.pi / 2, 0.0, -1e-3], abs=1e-13)
    # a double pendulum: the centre of mass hangs by 1 mm and 0.25 m
    inertia = 2 * np.array([[1e-6, 0.25e-3], [0.25e-3, 0.25**2 + 0.5**2 / 12]])
    squares = np.linalg.eigvals(np.linalg.solve(inertia, 2 * 9.81 * np.diag([1e-3, 0.25])))
    assert frequencies(data) == pytest.approx(np.sqrt(np.sort(squares)) / (2 * np.pi), rel=1e-10)


def test_a_follower_force_makes_ziegler_s_column_flutter():
    """Masses 2 and 1, springs 1, lengths 1: it flutters from P = 7/2 − √2 on [Ziegler 1952]."""
    text = """
    joints: {O: [0, 0]}
    bars:
      a: {joints: [O, P], length: 1}
      b: {joints: [P, Q], length: 1}
    masses: {P: 2, Q: 1}
    springs:
      - {between_bars: [ground, a], stiffness: 1, angle: 0}
      - {between_bars: [a, b], stiffness: 1, angle: 0}
    loads: [{joint: Q, force: [-LOAD, 0], on: b}]
    free: {a: {angle: 0.1, speed: 0}, b: {angle: 0.1, speed: 0}}
    """
    critical = 3.5 - np.sqrt(2)
    kinds = []
    for load in (critical - 1e-9, critical + 1e-9):
        data = equilibrium(linkages.loads(text.replace("LOAD", repr(float(load)))))
        assert data.sizes["equilibrium"] == 1
        assert not data["stable"][0]  # not even before: any damping may take that away
        values = data["eigenvalue"][0].to_numpy() @ [1, 1j]
        square = (7 - 2 * load) / 4  # 2 ω⁴ − (7 − 2P) ω² + 1 = 0
        expected = np.emath.sqrt(square + np.array([-1, 1]) * np.emath.sqrt(square**2 - 0.5))
        assert np.sort(np.abs(values)) == pytest.approx(np.sort(np.abs(expected)), rel=1e-7)
        kinds.append(sorted(data["mode_kind"][0].to_numpy().tolist()))
        reason = str(data["reason"][0].item())
        assert ("undecided" in reason) == (load < critical)
    assert kinds == [["undamped", "undamped"], ["damped", "growing"]]


def test_a_motor_with_inductance_has_a_further_eigenvalue():
    """J θ″ = k i − m g l/2 cos θ, L di/dt = U − R i − k θ′."""
    text = """
    gravity: [0, -9.81]
    joints: {O: [0, 0]}
    bars: {arm: {joints: [O, P], length: 0.3, mass: 0.5}}
    motors: {m: {bar: arm, voltage: 2, resistance: 1, torque_constant: 0.1, inductance: 0.05}}
    free: {arm: {angle: 0.1, speed: 0}}
    """
    one = equilibrium(linkages.loads(text)).sel(equilibrium=1)
    weight, inertia = 0.5 * 9.81 * 0.15, 0.5 * 0.3**2 / 3
    angle = -np.arccos(0.1 * 2 / weight)
    assert one["state"].to_numpy() == pytest.approx([angle, 0.0, 2.0], abs=1e-12)
    stiffness = -weight * np.sin(angle)
    cubic = np.polyadd(np.polymul([inertia, 0, stiffness], [0.05, 1]), [0.1**2, 0])
    values = one["eigenvalue"].to_numpy() @ [1, 1j]
    values = values[np.isfinite(values)]
    expected = [root for root in np.roots(cubic) if root.imag >= 0]
    assert sorted(values, key=abs) == pytest.approx(sorted(expected, key=abs), rel=1e-10)


@pytest.mark.parametrize("stiffness", [20, 300, 2000])
def test_minima_saddles_and_maxima_of_an_arm_balance(stiffness):
    """Signs of the Hessian at all equilibria add up to zero on a torus (Poincaré–Hopf)."""
    text = f"""
    gravity: [0, -9.81]
    joints: {{O: [0, 0], H: [0, 0.08], K: [-0.03, 0.06]}}
    bars:
      lower:
        {{points: {{O: [0, 0], Q: [0.1, 0], A: [0.4, 0]}}, mass: 1, center: [0.2, 0], inertia: 0}}
      upper:
        {{points: {{A: [0, 0], R: [-0.05, 0]}}, mass: 1.3, center: [0.3, 0.02], inertia: 0.01}}
    springs:
      - {{between: [H, Q], stiffness: 900, length: 0.05}}
      - {{between: [K, R], stiffness: {stiffness}, length: 0.2}}
    free: {{lower: {{angle: 60 deg, speed: 0}}, upper: {{angle: 10 deg, speed: 0}}}}
    """
    data = equilibrium(linkages.loads(text))
    unstable = (data["eigenvalue"].sel(part="real") > 1e-6).sum("mode").to_numpy()
    assert data["neutral"].sum() == 0
    assert ((-1.0) ** unstable).sum() == 0
    assert (unstable == 0).any()
    assert (unstable == 2).any()
