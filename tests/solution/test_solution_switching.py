"""Free coordinates exchanged on the way: the motion is the one of any other choice."""

import numpy as np
import pytest
from solution_mechanisms import FREE_CRANK, mechanism

import linkages

START, SPEED = np.pi / 3, 40.0


def free_crank():
    return mechanism(FREE_CRANK, f"free: {{crank: {{angle: {START!r}, speed: {SPEED}}}}}")


def free_piston():
    """The same state, said of the piston: x = r cos θ + √(l² − r² sin² θ)."""
    along = np.sqrt(0.14**2 - (0.04 * np.sin(START)) ** 2)
    position = 0.04 * np.cos(START) + along
    rate = -0.04 * np.sin(START) * (1 + 0.04 * np.cos(START) / along)
    return mechanism(
        FREE_CRANK,
        f"free: {{piston: {{position: {float(position)!r}, speed: {float(rate * SPEED)!r}}}}}",
    )


def changes(solution):
    return [note for note in solution.notes if "was exchanged for" in note]


@pytest.fixture(scope="module")
def crank_free():
    return linkages.simulate(free_crank(), end=1.0, samples=1001, rtol=1e-12, outputs="all")


@pytest.fixture(scope="module")
def piston_free():
    return linkages.simulate(free_piston(), end=1.0, samples=1001, rtol=1e-12, outputs="all")


def test_piston_cannot_stay_the_free_coordinate(crank_free, piston_free):
    """At the first dead centre the crank takes over, and stays; crank first, nothing changes."""
    (note,) = changes(piston_free)
    assert "piston was exchanged for crank" in note
    assert "better conditioned" in note
    assert changes(crank_free) == []
    time = float(note.split("t = ")[1].split(" s")[0])
    assert 0 < time < (np.pi - START) / 30  # before the first dead centre
    assert piston_free.motion.pieces[0].system.topology.free == ("piston",)
    assert piston_free.motion.pieces[-1].system.topology.free == ("crank",)


@pytest.mark.parametrize(
    ("name", "scale"),
    [("joint_position", 1.0), ("bar_angle", 1.0), ("bar_speed", 100.0), ("slider_position", 1.0),
     ("slider_velocity", 10.0), ("joint_velocity", 10.0), ("joint_reaction", 1e5)],
)  # fmt: skip
def test_motion_does_not_depend_on_the_coordinate(crank_free, piston_free, name, scale):
    """Six turns through twelve dead centres; both runs err by some 1e-12 per step."""
    found, wanted = (s.data[name].to_numpy() for s in (piston_free, crank_free))
    assert found == pytest.approx(wanted, abs=1e-9 * scale)


def test_progress_goes_on_over_a_change():
    seen = []
    solution = linkages.simulate(free_piston(), end=1.0, samples=3, watch=seen.append)
    assert len(changes(solution)) == 1
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_angles_go_on_over_a_change(piston_free):
    angle = piston_free.data.bar_angle.sel(bar="crank").to_numpy()
    assert (np.diff(angle) > 0).all()
    assert angle[-1] - angle[0] > 30
    assert np.abs(np.diff(angle)).max() < 0.1


def test_energy_and_closure_over_a_change(piston_free):
    """No work is done: the residual is the change of energy; 1e-12 of 1 J per step."""
    data = piston_free.data
    assert float(np.abs(data.energy_residual).max()) < 1e-9
    assert float(data.closure_residual.max()) <= 1e-13
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy == pytest.approx(energy[0], abs=1e-9)


def test_backward_in_time():
    data = [
        linkages.simulate(found, end=-1.0, samples=501, rtol=1e-12).data
        for found in (free_piston(), free_crank())
    ]
    for name in ("joint_position", "bar_angle"):
        assert data[0][name].to_numpy() == pytest.approx(data[1][name].to_numpy(), abs=1e-9)
    assert float(data[0].bar_angle.sel(bar="crank")[-1]) < -30


def test_there_and_back():
    """To the end with one coordinate, back with another: the start comes back."""
    forth = linkages.simulate(free_piston(), end=0.5, samples=2, rtol=1e-12).data.isel(time=-1)
    angle, speed = (float(forth[n].sel(bar="crank")) for n in ("bar_angle", "bar_speed"))
    b = [float(x) for x in forth.joint_position.sel(joint="B")]
    text = FREE_CRANK.replace("[0.156, 0]", str(b)).replace("A: [0.02, 0.034], ", "")
    back = linkages.simulate(
        mechanism(text, f"free: {{crank: {{angle: {angle!r}, speed: {speed!r}}}}}"),
        end=-0.5, samples=2, rtol=1e-12,
    ).data.isel(time=-1)  # fmt: skip
    start = [np.remainder(float(back.bar_angle.sel(bar="crank")), 2 * np.pi), float(
        back.bar_speed.sel(bar="crank"))]  # fmt: skip
    assert start == pytest.approx([START, SPEED], abs=1e-7)
    assert start[0] == pytest.approx(START, abs=1e-9)


@pytest.mark.parametrize("samples", [2, 3, 11])
def test_samples_do_not_matter(samples, piston_free):
    data = linkages.simulate(free_piston(), end=1.0, samples=samples, rtol=1e-12).data
    step = 1000 // (samples - 1)
    dense = piston_free.data.isel(time=slice(None, None, step))
    found = data.joint_position.to_numpy()
    assert found == pytest.approx(dense.joint_position.to_numpy(), abs=1e-10)
    assert found.shape[0] == samples


@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5", "rk4", "gauss8"])
def test_every_explicit_method_and_gauss8(method, crank_free):
    """Those with equal steps lose nothing when a run is cut: errors stay those of the step."""
    step = {"rk4": 2e-5, "gauss8": 2e-4}.get(method)
    data = linkages.simulate(
        free_piston(), end=0.2, samples=201, method=method, rtol=1e-11, step=step
    ).data
    dense = crank_free.data.isel(time=slice(0, 201))
    assert data.joint_position.to_numpy() == pytest.approx(
        dense.joint_position.to_numpy(), abs=1e-8
    )


@pytest.mark.slow
def test_radau(crank_free):
    """Through two dead centres, with errors of its order 5."""
    solution = linkages.simulate(free_piston(), end=0.2, samples=201, method="radau", rtol=1e-9)
    assert changes(solution)
    dense = crank_free.data.isel(time=slice(0, 201))
    assert solution.data.joint_position.to_numpy() == pytest.approx(
        dense.joint_position.to_numpy(), abs=1e-6
    )


def test_work_goes_on_over_a_change():
    """A load and a damper: energy = work so far, however many pieces there are."""
    more = (
        "loads: [{slider: piston, force: -20}, {bar: crank, torque: 2}]",
        "dampers: [{joint: A, damping: 0.01}]",
    )
    start = free_piston(), free_crank()
    found = [
        linkages.simulate(
            mechanism(FREE_CRANK, free, *more), end=0.5, samples=501, rtol=1e-11, outputs="all"
        ).data
        for free in (
            f"free: {{piston: {_free(start[0])}}}", f"free: {{crank: {_free(start[1], 'angle')}}}",
        )
    ]  # fmt: skip
    for data in found:
        moved = float(data.kinetic_energy.max())
        assert float(np.abs(data.energy_residual).max()) < 1e-8 * moved
    places = [data.joint_position.to_numpy() for data in found]
    assert places[0] == pytest.approx(places[1], abs=1e-8)


def _free(found, key="position"):
    (initial,) = found.initial.values()
    return f"{{{key}: {initial.position!r}, speed: {initial.speed!r}}}"


# -- a double rocker -------------------------------------------------------------------------

DOUBLE_ROCKER = """\
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.3, 0]}
bars:
  left: {joints: [O, A], length: 0.2, mass: 1}
  coupler: {joints: [A, B], length: 0.12, mass: 1}
  right: {joints: [C, B], length: 0.25, mass: 1}
assembly: {A: [0.02, -0.2], B: [0.11, -0.17]}
"""


def test_double_rocker_swings_through_its_dead_points():
    """No bar but the coupler turns fully: whichever is free comes to an end, and others go on.

    Started with either rocker free in the same state, the motion is the same.
    """
    first = linkages.simulate(
        mechanism(DOUBLE_ROCKER, "free: {left: {angle: -85 deg, speed: 0}}"),
        end=3.0, samples=1501, rtol=1e-12, outputs="all",
    )  # fmt: skip
    start = first.data.isel(time=0)
    angle = float(start.bar_angle.sel(bar="right"))
    second = linkages.simulate(
        mechanism(DOUBLE_ROCKER, f"free: {{right: {{angle: {angle!r}, speed: 0}}}}"),
        end=3.0, samples=1501, rtol=1e-12, outputs="all",
    )  # fmt: skip
    assert changes(first) or changes(second)
    # some five swings; nearby motions part by a factor of 1e3
    found, wanted = (s.data.joint_position.to_numpy() for s in (second, first))
    assert found == pytest.approx(wanted, abs=1e-8)
    for solution in (first, second):
        assert float(np.abs(solution.data.energy_residual).max()) < 1e-9
        assert float(solution.data.closure_residual.max()) <= 1e-13


def test_double_rocker_thrown_over():
    """Fast enough for the coupler to turn over and over, while both rockers swing.

    Both rockers are given up for it before long; it stays, because it never has a dead point.
    """
    solution = linkages.simulate(
        mechanism(DOUBLE_ROCKER, "free: {left: {angle: -85 deg, speed: 30}}"),
        end=2.0, samples=2001, rtol=1e-11, outputs="all",
    )  # fmt: skip
    data = solution.data
    assert changes(solution)[-1].split(",")[0].endswith("was exchanged for coupler")
    assert abs(float(data.bar_angle.sel(bar="coupler")[-1])) > 20
    assert float(np.ptp(data.bar_angle.sel(bar="left").to_numpy())) < 2 * np.pi
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy == pytest.approx(energy[0], rel=1e-7)
    assert float(data.closure_residual.max()) <= 1e-13
    # bars stay as long as they are, whatever is free
    places = {j: data.joint_position.sel(joint=j).to_numpy() for j in "OABC"}
    for one, other, length in (("O", "A", 0.2), ("A", "B", 0.12), ("C", "B", 0.25)):
        found = np.hypot(*(places[other] - places[one]).T)
        assert found == pytest.approx(length, abs=1e-14)
    for bar in ("left", "coupler", "right"):
        speed = data.bar_speed.sel(bar=bar).to_numpy()
        turned = data.bar_angle.sel(bar=bar).to_numpy()
        steps = 0.5e-3 * (speed[1:] + speed[:-1])
        assert np.diff(turned) == pytest.approx(steps, abs=0.05)  # no jump of a turn


def test_angles_go_on_over_a_change_and_then_a_change_point():
    """The turns of a bar before it was taken as free are not forgotten behind the next one."""
    text = """\
joints: {O: [0, 0], C: [0.4, 0]}
gravity: [0, -9.81]
bars:
  left: {joints: [O, A], length: 0.25, mass: 1}
  coupler: {joints: [A, B], length: 0.15, mass: 0.5}
  right: {joints: [C, B], length: 0.3, mass: 1.5}
free: {left: {angle: 80 deg}}
assembly: {B: [0.2, 0.25]}
"""
    solution = linkages.simulate(mechanism(text), end=1.0, samples=1001, rtol=1e-10)
    assert changes(solution)
    assert any("change point" in note for note in solution.notes)
    for bar in ("left", "coupler", "right"):
        speed, angle = (
            solution.data[v].sel(bar=bar).to_numpy() for v in ("bar_speed", "bar_angle")
        )
        steps = 0.5e-3 * (speed[1:] + speed[:-1])
        assert np.diff(angle) == pytest.approx(steps, abs=0.05)


# -- two free coordinates --------------------------------------------------------------------

FIVE_BAR = """\
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.5, 0]}
bars:
  one: {joints: [O, A], length: 0.3, mass: 1}
  two: {joints: [A, B], length: 0.35, mass: 0.5}
  three: {joints: [C, B], length: 0.35, mass: 0.5}
  four: {joints: [D, C], length: 0.25, mass: 1}
assembly: {A: [0.0, -0.3], B: [0.25, -0.55], C: [0.5, -0.25]}
"""


def test_two_free_coordinates():
    """A five-bar linkage thrown about: the same motion from two sets of free coordinates."""
    outer = linkages.simulate(
        mechanism(FIVE_BAR, "free: {one: {angle: -90 deg, speed: 4}, four: {angle: -90 deg, "
                  "speed: -7}}"),
        end=1.5, samples=751, rtol=1e-12, outputs="all",
    )  # fmt: skip
    start = outer.data.isel(time=0)
    free = ", ".join(
        f"{bar}: {{angle: {float(start.bar_angle.sel(bar=bar))!r}, "
        f"speed: {float(start.bar_speed.sel(bar=bar))!r}}}"
        for bar in ("one", "two")
    )
    inner = linkages.simulate(
        mechanism(FIVE_BAR, f"free: {{{free}}}"), end=1.5, samples=751, rtol=1e-12, outputs="all"
    )
    assert changes(outer) or changes(inner)
    for solution in (outer, inner):
        assert len(solution.motion.pieces[-1].system.topology.free) == 2
        data = solution.data
        energy = (data.kinetic_energy + data.potential_energy).to_numpy()
        assert energy == pytest.approx(energy[0], abs=1e-9)
        assert float(data.closure_residual.max()) <= 1e-13
    early = slice(0, 376)
    found, wanted = (s.data.joint_position.to_numpy()[early] for s in (inner, outer))
    # a chaotic motion: errors of 1e-12 grow by some thousands in 0.75 s
    assert found == pytest.approx(wanted, abs=1e-8)


WOUND = (
    "springs: [{between_bars: [one, two], stiffness: 0.003, angle: 0}, "
    "{bar: four, stiffness: 0.002, angle: 0}]"
)
GEARED = "gears: [{bars: [one, wheel], ratio: 1.618033988749895}]"
WHEEL = "  wheel: {joints: [O, W], length: 0.1, mass: 0.3}\n"


@pytest.mark.slow
@pytest.mark.parametrize("speeds", [(20, -7), (9, 14), (-15, 20)], ids=str)
@pytest.mark.parametrize("kind", ["springs", "gear"])
def test_whole_turns_are_kept_over_changes(kind, speeds):
    """Springs wound up, and a gear with a ratio of its own, see the turns of bars that change.

    Without weight the cranks turn over and over; on the way either of them is given up and taken
    again, many times.
    """
    text = FIVE_BAR.replace("[0, -9.81]", "[0, 0]")
    if kind == "gear":
        text = text.replace("assembly:", WHEEL + "assembly:")
    solution = linkages.simulate(
        mechanism(text, WOUND if kind == "springs" else GEARED,
                  f"free: {{one: {{angle: -90 deg, speed: {speeds[0]}}}, "
                  f"four: {{angle: -90 deg, speed: {speeds[1]}}}}}"),
        end=3.0, samples=3001, rtol=1e-11, outputs="all",
    )  # fmt: skip
    data = solution.data
    assert len(changes(solution)) > 5
    angle = {bar: data.bar_angle.sel(bar=bar).to_numpy() for bar in ("one", "two", "four")}
    assert np.ptp(angle["four" if kind == "springs" else "one"]) > 2 * np.pi
    if kind == "springs":
        wound = angle["two"] - angle["one"]
        stored = 0.5 * 0.003 * wound**2 + 0.5 * 0.002 * angle["four"] ** 2
        assert data.potential_energy.to_numpy() == pytest.approx(stored, abs=1e-12)
    else:
        wheel = data.bar_angle.sel(bar="wheel").to_numpy()
        assert wheel == pytest.approx(1.618033988749895 * angle["one"], abs=1e-12)
        arm = data.joint_position.sel(joint="W").to_numpy()
        expected = 0.1 * np.stack([np.cos(wheel), np.sin(wheel)], axis=1)
        assert arm == pytest.approx(expected, abs=1e-12)
    # some 25 changes, each close to where something is ill-conditioned
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy == pytest.approx(energy[0], rel=1e-8)
    assert float(data.closure_residual.max()) <= 1e-13


def test_clearances_are_never_exchanged():
    solution = linkages.simulate(linkages.load("ninebar"), end=0.1, samples=11)
    assert changes(solution) == []
    text = FREE_CRANK + "clearances: {r: {joint: B, bar: rod, size: 1e-4, angle: 1}}\n"
    (initial,) = free_piston().initial.values()
    found = mechanism(
        text, f"free: {{piston: {{position: {initial.position!r}, speed: {initial.speed!r}}}}}"
    )
    solution = linkages.simulate(found, end=0.15, samples=301, rtol=1e-11, outputs="all")
    assert changes(solution)
    assert all("r" in piece.system.topology.free for piece in solution.motion.pieces)
    assert float(np.abs(solution.data.energy_residual).max()) < 1e-7


def test_start_at_a_dead_centre_goes_nowhere():
    """There the piston says nothing about where the crank goes."""
    found = mechanism(FREE_CRANK.replace("[0.156, 0]", "[0.18, 0]"),
                      "free: {piston: {position: 0.18, speed: 0}}")  # fmt: skip
    with pytest.raises(linkages.LinkagesError) as caught:
        linkages.simulate(found, end=0.1)
    assert "singular" in str(caught.value)
