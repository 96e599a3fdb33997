"""Groups without a closed form: solved by Newton's iteration, as exactly as the others."""

import numpy as np
import pytest
from solution_mechanisms import derivative, mechanism

import linkages
from linkages.reading.document import find

BODY = find("class-three").read_text(encoding="utf-8").split("drives:")[0]
HINTS = """\
assembly: {E: [138 mm, 212 mm], F: [217 mm, 28 mm], G: [321 mm, 192 mm]}
"""
START = "free: {crank: {angle: 0, speed: 10}}\n"
METHODS = ["dop853", "vern9", "tsit5", "rk4", "gauss8", "radau"]
STEP = {"rk4": 1e-4, "gauss8": 2e-3}


def free(start=START):
    return mechanism(BODY + start + HINTS)


@pytest.fixture(scope="module")
def reference():
    return linkages.simulate(
        free(), end=1.0, samples=1001, method="dop853", rtol=1e-13, outputs="all"
    )


def test_shipped_mechanism_closes():
    solution = linkages.simulate(linkages.load("class-three"), outputs="all")
    data = solution.data
    assert float(data.closure_residual.max()) <= 1e-13
    # work is integrated along with what is carried, at 1e-10
    assert float(np.abs(data.energy_residual).max()) < 1e-10
    assert solution.system.topology.free == ()
    assert [b.kind for b in solution.system.topology.solved_blocks] == ["N"]


def test_efforts_are_the_derivative_of_energy():
    spacing = 1e-3
    data = linkages.simulate(
        linkages.load("class-three"), end=1.0, samples=1001, outputs="all"
    ).data
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    # round-off of 1e-16 J over the spacing
    assert derivative(energy, spacing) == pytest.approx(data.drive_power.to_numpy()[4:-4], abs=1e-9)
    for bar in ("leg1", "leg2", "leg3", "plate"):
        speed = data.bar_speed.sel(bar=bar).to_numpy()
        found = derivative(data.bar_angle.sel(bar=bar).to_numpy(), spacing)
        assert found == pytest.approx(speed[4:-4], abs=1e-10)
        found = derivative(speed, spacing)
        wanted = data.bar_acceleration.sel(bar=bar).to_numpy()[4:-4]
        assert found == pytest.approx(wanted, abs=1e-8)


@pytest.mark.slow_except("2", "11")
@pytest.mark.parametrize("samples", [2, 3, 11, 101])
def test_driven_samples_do_not_depend_on_how_many_there_are(samples):
    """Every sample is solved for itself, so coarse ones are some of the dense ones."""
    dense = linkages.simulate(linkages.load("class-three"), end=2.0, samples=1001).data
    data = linkages.simulate(linkages.load("class-three"), end=2.0, samples=samples).data
    picked = dense.isel(time=slice(None, None, 1000 // (samples - 1)))
    for name in ("joint_position", "bar_speed", "bar_acceleration", "drive_effort"):
        scale = max(1.0, float(np.abs(dense[name]).max()))
        assert data[name].to_numpy() == pytest.approx(picked[name].to_numpy(), abs=1e-13 * scale)


def test_free_motion_closes_and_balances(reference):
    data = reference.data
    assert float(data.closure_residual.max()) <= 1e-13
    assert float(np.abs(data.energy_residual).max()) < 1e-11
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy == pytest.approx(energy[0], abs=1e-11)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_energy_residual_is_at_the_tolerance(rtol):
    data = linkages.simulate(free(), end=1.0, samples=101, rtol=rtol, outputs="all").data
    # some hundred steps of rtol on 0.5 J, with the sensitivity of a spinning crank
    assert float(np.abs(data.energy_residual).max()) < 100 * rtol
    # closure does not know of the tolerance
    assert float(data.closure_residual.max()) <= 1e-13


@pytest.mark.slow_except("rk4", "gauss8")
@pytest.mark.parametrize("method", METHODS)
def test_every_method(method, reference):
    """Each to its own accuracy: orders 4 and 8 at their steps, radau at 1e-8."""
    end = 0.2 if method == "radau" else 1.0
    count = round(1000 * end) + 1
    rtol = 1e-8 if method == "radau" else 1e-11
    solution = linkages.simulate(
        free(), end=end, samples=count, method=method, rtol=rtol, step=STEP.get(method),
        outputs=["joint_position", "bar_angle", "bar_speed", "closure_residual"],
    )  # fmt: skip
    data, exact = solution.data, reference.data.isel(time=slice(0, count))
    limit = {"rk4": 1e-7, "gauss8": 1e-8, "radau": 1e-5}.get(method, 1e-8)
    found, wanted = data.joint_position.to_numpy(), exact.joint_position.to_numpy()
    assert found == pytest.approx(wanted, abs=limit)
    assert data.bar_speed.to_numpy() == pytest.approx(exact.bar_speed.to_numpy(), abs=100 * limit)
    assert float(data.closure_residual.max()) <= 1e-13


@pytest.mark.slow_except("gauss8")
@pytest.mark.parametrize("method", ["dop853", "vern9", "gauss8"])
def test_there_and_back(method):
    arguments = {"method": method, "rtol": 1e-12, "step": STEP.get(method), "samples": 3}
    forth = linkages.simulate(free(), end=0.5, **arguments).data.isel(time=-1)
    angle, speed = (float(forth[n].sel(bar="crank")) for n in ("bar_angle", "bar_speed"))
    places = {j: [float(x) for x in forth.joint_position.sel(joint=j)] for j in "EFG"}
    hints = "assembly:\n" + "".join(f"  {j}: {place}\n" for j, place in places.items())
    start = f"free: {{crank: {{angle: {angle!r}, speed: {speed!r}}}}}\n"
    back = linkages.simulate(mechanism(BODY + start + hints), end=-0.5, **arguments).data
    last = back.isel(time=-1)
    limit = 1e-7 if method == "gauss8" else 1e-9
    assert float(last.bar_angle.sel(bar="crank")) == pytest.approx(0, abs=limit)
    assert float(last.bar_speed.sel(bar="crank")) == pytest.approx(10, abs=100 * limit)
    first = linkages.simulate(free(), end=0.5, samples=3).data.isel(time=0)
    for joint in "EFG":
        assert last.joint_position.sel(joint=joint).to_numpy() == pytest.approx(
            first.joint_position.sel(joint=joint).to_numpy(), abs=limit
        )


@pytest.mark.slow_except("2", "6")
@pytest.mark.parametrize("samples", [2, 6, 51])
def test_samples_of_a_free_motion(samples, reference):
    """Dense output of order 7 between steps: coarse and dense samples come from the same steps."""
    arguments = {"end": 1.0, "method": "dop853", "rtol": 1e-13}
    data = linkages.simulate(free(), samples=samples, **arguments).data
    dense = reference.data.isel(time=slice(None, None, 1000 // (samples - 1)))
    # asking for the energy residual there adds an integrand, and changes steps
    assert data.joint_position.to_numpy() == pytest.approx(
        dense.joint_position.to_numpy(), abs=1e-10
    )
    plain = linkages.simulate(free(), samples=1001, **arguments).data
    picked = plain.isel(time=slice(None, None, 1000 // (samples - 1)))
    assert data.joint_position.to_numpy() == pytest.approx(
        picked.joint_position.to_numpy(), abs=1e-14
    )


def test_reactions_obey_newton(reference):
    """The plate: pushed by its three legs alone, which pin it at E, F and G."""
    data = reference.data
    legs = {"E": "leg1", "F": "leg2", "G": "leg3"}
    order = list(linkages.load("class-three").bodies)
    force = 0.0
    for joint, leg in legs.items():
        sign = 1 if order.index(leg) < order.index("plate") else -1
        force = force + sign * data.joint_reaction.sel(joint=joint).to_numpy()
    e, f = (data.joint_acceleration.sel(joint=j).to_numpy() for j in "EF")
    along, normal = 97 / 200, 53 / 200
    across = (f - e) @ np.array([[0, 1], [-1, 0]])
    centre = e + along * (f - e) + normal * across
    weight = np.array([0, -9.81])
    assert force == pytest.approx(0.8 * (centre - weight), abs=1e-10)
