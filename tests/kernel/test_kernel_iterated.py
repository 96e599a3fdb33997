"""Groups without a closed form: a plate on three links, driven and free, along whole turns."""

import numpy as np
import pytest
from group_models import TRIAD, WITH_SLIDER
from kernel_motion import call, carried_along, difference
from linkage_models import refusal, system_of, values
from scipy.optimize import fsolve

from linkages.kernel.code.program import bind_kernel, write_program
from linkages.kernel.dyads import Iterated, LinkAndSlider
from linkages.kernel.state_jumps import jacobian_nodes, write_jacobian

MODELS = {"plate on three legs": TRIAD, "with a slider": WITH_SLIDER}
TURN = np.linspace(0, 2 * np.pi / 3, 181)
MODEL = pytest.mark.parametrize("text", MODELS.values(), ids=MODELS)


def free(text):
    """The crank is free, the group the same."""
    return text.replace("drives: {crank: {angle: 0", "free: {crank: {angle: 0")


@pytest.mark.slow_except("plate*")
@MODEL
def test_it_closes_over_a_turn_of_the_crank(text):
    of = system_of(text)
    (block,) = of.topology.solved_blocks
    assert (block.kind, len(block.unknowns), len(block.loops)) == ("N", 4, 2)
    states = carried_along(of, TURN)
    residual = values(of, "closure_residual", TURN, states)
    assert np.abs(residual).max() < 1e-13  # lengths below 1 m, conditions below 100
    # and comes back to where it was: the same mode, whatever the number of turns
    assert states[:, -1] == pytest.approx(states[:, 0], abs=1e-12)


def test_positions_are_those_of_another_solver():
    of = system_of(TRIAD)
    states = carried_along(of, TURN)
    places = values(of, "joint_position", TURN, states).reshape(len(of.topology.joints), 2, -1)
    at = dict(zip(of.topology.joints, places, strict=True))
    for k in (0, 40, 111):
        foot = 0.05 * np.array([np.cos(3 * TURN[k]), np.sin(3 * TURN[k])])

        def lengths(pose, foot=foot):
            e = np.exp(1j * pose[2])
            e, f, g = (complex(*pose[:2]) + v * e for v in (0, 0.2, 0.09 + 0.16j))
            legs = [(e, complex(*foot), 0.23), (f, 0.33 - 0.07j, 0.15), (g, 0.25 + 0.39j, 0.21)]
            return [abs(p - q) ** 2 - length**2 for p, q, length in legs]

        (ex, ey), (fx, fy) = at["E"][:, k], at["F"][:, k]
        start = [ex + 0.003, ey - 0.002, np.arctan2(fy - ey, fx - ex) + 0.01]
        found = fsolve(lengths, start, xtol=1e-12)
        assert found[:2] == pytest.approx([ex, ey], abs=1e-11)  # to its own tolerance


@pytest.mark.slow_except("plate*")
@MODEL
def test_rates_and_accelerations_along_the_turn(text):
    """Against differences of positions and rates; what is carried along may be a little off."""
    of = system_of(text)
    states = carried_along(of, TURN)
    step = 2e-3
    pairs = [
        ("joint_position", "joint_velocity"),
        ("joint_velocity", "joint_acceleration"),
        ("bar_angle", "bar_speed"),
        ("bar_speed", "bar_acceleration"),
    ]
    for k in (0, 50, 120):
        state = states[:, k : k + 1]
        for below, above in pairs:
            slope = difference(
                lambda h, n=below, s=state, k=k: values(of, n, TURN[k] + h, s)[:, 0], step
            )
            found = values(of, above, TURN[k], state)[:, 0]
            size = max(1.0, np.abs(found).max())
            assert found == pytest.approx(slope, abs=1e-10 * size)  # 1e-14/step


def test_what_it_starts_from_does_not_matter():
    """A start that is 0.01 rad off gives the same positions, rates and margins."""
    of = system_of(TRIAD)
    random = np.random.default_rng(5)
    model = of.model
    nodes = [*model.settled, *model.margins, *model.margin_rates]
    exact = of.evaluate(nodes, 0.3)[:, 0]
    for _ in range(10):
        state = of.state + random.uniform(-0.01, 0.01, len(of.state))
        found = of.evaluate(nodes, 0.3, state[:, None])[:, 0]
        assert found == pytest.approx(exact, rel=1e-12, abs=1e-13)


@MODEL
def test_margins_change_at_their_rates(text):
    of = system_of(text)
    model = of.model
    rate = of.evaluate(model.margin_rates, 0.2)[:, 0]
    slope = difference(lambda h: of.evaluate(model.margins, 0.2 + h)[:, 0], 2e-3)
    scale = of.evaluate(model.margin_scales)[:, 0]
    assert rate == pytest.approx(slope, abs=1e-11 * scale.max())
    # a determinant is not larger than the product of the lengths of its columns (Hadamard)
    assert np.all(np.abs(of.evaluate(model.margins)[:, 0]) <= scale)


def test_the_margin_is_zero_where_three_legs_meet_in_a_point():
    """Legs whose lines meet in one point cannot hold the plate: it can turn about that point."""
    angles = np.array([0.3, 2.2, 4.5])
    corners = 0.1 * np.exp(1j * angles)
    feet = 0.5 * np.exp(1j * angles)  # all lines through the origin
    points = [f"[{c.real!r}, {c.imag!r}]" for c in corners.tolist()]
    hints = [f"[{c.real!r}, {c.imag!r}]" for c in (corners * np.exp(0.3j)).tolist()]
    text = f"""
joints: {{O: [{feet[0].real + 0.05}, {feet[0].imag}], C: [{feet[1].real}, {feet[1].imag}],
  D: [{feet[2].real}, {feet[2].imag}]}}
bars:
  crank: {{joints: [O, A], length: 0.05}}
  leg1: {{joints: [A, E], length: 0.4}}
  leg2: {{joints: [C, F], length: 0.4}}
  leg3: {{joints: [D, G], length: 0.4}}
  plate: {{points: {{E: {points[0]}, F: {points[1]}, G: {points[2]}}}}}
drives: {{crank: {{angle: ANGLE, speed: 1}}}}
assembly: {{E: {hints[0]}, F: {hints[1]}, G: {hints[2]}}}
"""
    relative = []
    for away in (0.01, 0.001):  # the foot comes closer than where the lines meet
        of = system_of(text.replace("ANGLE", repr(np.pi + away)))
        margin, scale = of.evaluate([*of.model.margins, *of.model.margin_scales])[:, 0]
        relative.append(abs(margin) / scale)
    # two assembly modes merge: the plate turns with the root of what the foot moves
    assert relative[0] < 0.03
    assert relative[0] / relative[1] == pytest.approx(np.sqrt(10), rel=0.02)


# --- the equations of motion, compiled and differentiated ---------------------------------------


def kernels(text):
    of = system_of(text)
    model = of.model
    accelerations = model.integrated_accelerations(model.changes)
    program = write_program(model, accelerations)
    return of, accelerations, program


@pytest.mark.slow_except("*plate*")
@MODEL
@pytest.mark.parametrize("change", [str, free], ids=["driven", "free"])
def test_compiled_equals_evaluated(text, change):
    of, accelerations, program = kernels(change(text))
    model = of.model
    roots = [*accelerations, *model.margins, *model.margin_rates, *model.settled]
    kernel = bind_kernel(program, of.parameters)
    for time in (0.0, 0.05):
        state = of.state + 0.01
        clock, rates, found = call(kernel, time, state, len(roots))
        assert (clock, rates) == (0, 0)
        expected = of.evaluate(roots, time, state[:, None])[:, 0]
        # fused multiply-adds, and a linear system of condition 100
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-12 * np.abs(expected).max())


def test_what_cannot_be_assembled_is_a_status():
    """The number of the block, if the crank pulls the plate out of reach or starts too far off."""
    of, _, program = kernels(free(TRIAD.replace("length: 0.05", "length: 0.3")))
    kernel = bind_kernel(program, of.parameters)
    size = len(of.state) // 2
    assert call(kernel, 0.0, of.state, size)[:2] == (0, 0)
    away, nan = of.state.copy(), of.state.copy()
    away[0], nan[0] = of.state[0] + 2.5, np.nan
    for state in (away, nan):
        assert call(kernel, 0.0, state, size)[:2] == (0, 1)
        assert np.isnan(of.evaluate(of.model.settled, 0.0, state[:, None])).any()


def test_a_printed_kernel_says_what_it_writes():
    _, _, program = kernels(free(TRIAD))
    written = (
        "accelerations (5), margins of the blocks (1), their rates (1), "
        "settled values of 4 coordinates, their rates (4)"
    )
    assert written in " ".join(program.text.split())


@pytest.mark.slow_except("*1-leg1")
@pytest.mark.parametrize("name", ["leg1", "leg2", "leg3", "plate"])
@pytest.mark.parametrize("side", [1, -1])
def test_a_correction_that_turns_a_body_far_is_no_position(name, side):
    """Beyond half a radian it need not be the same mode any more, although it converges."""
    of, _, program = kernels(free(TRIAD))
    kernel = bind_kernel(program, of.parameters)
    size, place = len(of.state) // 2, of.topology.coordinates.index(name)
    for turned, status in ((0.49, 0), (0.51, 1)):
        away = of.state.copy()
        away[place] += side * turned
        assert call(kernel, 0.0, away, size)[:2] == (0, status)


@pytest.mark.slow_except("plate*")
@MODEL
def test_exact_jacobians_of_a_free_crank(text):
    """Evaluated and compiled, against differences of the accelerations."""
    of, accelerations, _ = kernels(free(text))
    model = of.model
    parameters = of.parameters
    state = of.state.copy()
    n = len(state) // 2
    state[n] += 2.0
    rows = jacobian_nodes(model, accelerations)
    exact = np.array([of.evaluate(row, 0.0, state[:, None])[:, 0] for row in rows])

    def at(shift, k):
        moved = state.copy()
        moved[k] += shift
        return of.evaluate(accelerations, 0.0, moved[:, None])[:, 0]

    slopes = np.array(
        [difference(lambda h, k=k: at(h, k), 1e-3 if k < n else 1e-1) for k in range(2 * n)]
    ).T
    scale = np.abs(exact).max()
    assert exact == pytest.approx(slopes, abs=1e-9 * scale)
    # positions follow from the crank alone: what is carried along has no influence
    carried = [k for k in range(2 * n) if k not in (0, n)]
    assert np.abs(exact[:, carried]).max() <= 1e-9 * scale
    kernel = bind_kernel(write_jacobian(model, accelerations), parameters)
    clock, rates, found = call(kernel, 0.0, state, exact.size)
    assert (clock, rates) == (0, 0)
    assert found == pytest.approx(exact.ravel(), abs=1e-11 * scale)


@MODEL
def test_accelerations_are_those_of_newton_and_lagrange(text):
    """The energy of a free motion does not change: dT/dt + dV/dt = 0 along the equations."""
    of, accelerations, _ = kernels(free(text).replace("speed: 3", "speed: 4"))
    model = of.model
    start, second = of.state, of.evaluate(accelerations)[:, 0]
    n = len(start) // 2
    names = ("kinetic_energy", "potential_energy")

    def energy(h):
        state = np.concatenate(
            [start[:n] + h * start[n:] + 0.5 * h * h * second, start[n:] + h * second]
        )
        return sum(values(of, name, 0.0, state[:, None])[0, 0] for name in names)

    (kinetic,) = values(of, "kinetic_energy")[0]
    assert difference(energy, 1e-3) == pytest.approx(0.0, abs=1e-10 * max(kinetic, 1.0))
    (power,) = of.evaluate([model.power])[0]
    assert power == 0.0


# --- what is solved how -------------------------------------------------------------------------


def test_a_group_behind_dyads_and_dyads_behind_a_group():
    text = TRIAD.replace(
        "drives:",
        "  tie: {joints: [E, X], length: 0.2}\n  arm: {joints: [D, X], length: 0.2}\ndrives:",
    ).replace("assembly: {", "assembly: {X: left, ")
    of = system_of(text)
    assert [b.kind for b in of.topology.solved_blocks] == ["N", "RRR"]
    states = carried_along(of, TURN)
    assert np.abs(values(of, "closure_residual", TURN, states)).max() < 1e-13


def test_dyads_are_never_iterated():
    of = system_of(WITH_SLIDER.replace("plate: {points: {E: [0, 0], F: [0.2, 0], G: [0.09, 0.16]}",
        "plate: {points: {E: [0, 0], F: [0.2, 0]}").replace("joint: G", "joint: F").replace(
            "  leg2: {joints: [C, F], length: 0.15, mass: 0.3}\n", "").replace(
                ", F: [0.217, 0.028], G: [0.321, 0.192]}", "}").replace(
                    "drives: {", "drives: {plate: {angle: 0.3, speed: 0.1}, "))  # fmt: skip
    dyads = of.model.positions.dyads
    assert [type(dyad) for dyad in dyads.values()] == [LinkAndSlider]
    assert isinstance(system_of(TRIAD).model.positions.dyads[0], Iterated)


def test_missing_hint_lists_all_places():
    message = refusal(TRIAD.split("assembly")[0])
    assert "the group of 2 loops at joint" in message
    assert "can be assembled in 2 ways" in message
    assert "(F would be at [0.4281, 0.04347], [0.2168, 0.02837])" in message


def test_a_group_that_cannot_be_assembled():
    message = refusal(TRIAD.replace("length: 0.23", "length: 0.01"))
    assert "cannot be assembled: no position of" in message


def test_a_side_says_nothing_about_a_group():
    text = TRIAD.split("assembly")[0] + "assembly:\n  E: left\n"
    assert "joint E is in a group of 2 loops; expected its approximate position" in refusal(text)
