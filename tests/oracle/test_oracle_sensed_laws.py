"""Random mechanisms whose loads depend on random quantities, against the absolute formulation."""

import numpy as np
import pytest
import yaml
from absolute_coordinates import AbsoluteModel
from absolute_outputs import outputs
from kernel_values import assert_motion_agrees, at_start, disagreements
from random_mechanisms import plain, seeded

import linkages

TOLERANCE = 1e-11
"""As for random mechanisms with loads that depend on time."""


def quantities(random, mechanism):
    """What a formula may use; angles within sines, so that whole turns do not count."""
    bodies = [body for body in mechanism.bodies.values() if body.kind != "clearance"]
    joints = dict.fromkeys([*mechanism.ground, *(j for body in bodies for j in body.points)])
    joints = [joint for joint in joints if "." not in joint]
    one, other = random.choice(joints, 2, replace=False)
    found = [f"{one}.x", f"tanh({other}.vy)", f"distance({one}, {other})"]
    found.append(f"tanh(rate(distance({one}, {other})))")
    turning = [name for name, body in mechanism.bodies.items() if body.rotates]
    for name in random.permutation(turning)[:2]:
        found += [f"sin({name}.angle)", f"tanh({name}.speed)"]
    if len(turning) > 1:
        first, second = random.choice(turning, 2, replace=False)
        found += [f"cos(angle({first}, {second}))", f"tanh(rate(angle({first}, {second})))"]
    for name, body in mechanism.bodies.items():
        if not body.rotates:
            found += [f"{name}.position", f"tanh({name}.velocity)"]
    return found


def formula(random, mechanism):
    """A sum of three products of quantities, one of them behind a switch."""
    known = quantities(random, mechanism)
    terms = [
        f"{random.uniform(-3, 3)!r}*{random.choice(known)}*{random.choice(known)}" for _ in range(3)
    ]
    terms[2] = f"where({random.choice(known)} > {random.choice(known)}, {terms[2]}, cos(3*t))"
    return " + ".join([*terms, f"abs({random.choice(known)})"])


def sensing(seed, most):
    """A random mechanism with two more loads."""
    random, grown = np.random.default_rng(seed), seeded(seed, most=most)
    turning = [
        name for name, body in grown.mechanism.bodies.items() if body.kind in ("bar", "plate")
    ]
    more = [
        {"bar": str(random.choice(turning)), "torque": formula(random, grown.mechanism)}
        for _ in range(2)
    ]
    definition = {**grown.definition, "loads": [*grown.definition.get("loads", []), *more]}
    return grown, linkages.loads(yaml.safe_dump(plain(definition), sort_keys=False))


@pytest.mark.slow_except("0", "1", "3", "4", "6", "7", "8")
@pytest.mark.parametrize("seed", range(24))
def test_at_the_start(seed):
    grown, mechanism = sensing(seed, most=4)
    model = AbsoluteModel(mechanism)
    expected = outputs(model, model.solve(grown.start(model)))
    assert not disagreements(at_start(mechanism), expected, TOLERANCE), mechanism.to_yaml()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_motion(seed):
    """Samples, with the modes of each, and the balance of energy across switches."""
    grown, mechanism = sensing(seed, most=3)
    model = AbsoluteModel(mechanism)
    names = [*outputs(model, model.solve(grown.start(model))), "kinetic_energy", "energy_residual"]
    data = linkages.simulate(
        mechanism, end=0.05, samples=4, rtol=1e-11, outputs=names, throw=False
    ).data
    assert_motion_agrees(model, data, TOLERANCE, 1e-8)
