"""Shaking forces against the momentum of all masses, and a textbook's partial balance."""

import numpy as np
import pytest

import linkages

STEP = 1e-4


def momenta(mechanism, time):
    """Momentum and angular momentum about the origin, from where bodies are at some times."""
    step = STEP
    times = time + step * np.arange(-3, 4)
    data = linkages.simulate(mechanism, times=times, outputs=["joint_position", "bar_angle"]).data

    def place(joint):
        return data.joint_position.sel(joint=joint).to_numpy()

    rates = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * step)
    bends = np.array([2, -27, 270, -490, 270, -27, 2]) / (180 * step**2)
    force, moment = np.zeros(2), 0.0
    for component in mechanism.components:
        if component.section == "bars" and component.mass:
            start, end = place(component.joints[0]), place(component.joints[1])
            centre, inertia = (start + end) / 2, component.mass * component.length**2 / 12
            turned = bends @ data.bar_angle.sel(bar=component.name).to_numpy()
            moment += inertia * turned
        elif component.section == "sliders" and component.mass:
            centre = place(component.joint)
        else:
            continue
        acceleration = bends @ centre
        force += component.mass * acceleration
        moment += component.mass * np.cross(centre[3], acceleration)
    assert rates @ times == pytest.approx(1.0)
    return force, moment


@pytest.mark.parametrize("time", [0.003, 0.0117])
def test_shaking_is_the_rate_of_momentum(time):
    engine = linkages.load("slider-crank", set={"bars.rod.inertia": "null"})
    force, moment = momenta(engine, time)
    data = linkages.simulate(
        engine, times=[0.0, time], outputs=["shaking_force", "shaking_moment"]
    ).data.isel(time=1)
    # differences of sixth order lose 1e-16 m/step^2 = 1e-8 of accelerations of 1000 m/s^2 to round-off
    assert data.shaking_force.to_numpy()[0] == pytest.approx(-force, rel=1e-6, abs=1e-4)
    assert float(data.shaking_moment[0]) == pytest.approx(-moment, rel=1e-6)


YOKE = """
gravity: [0, 0]
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 50 mm, mass: 0.6}}
counterweights: {weight: {bar: crank, joint: O, mass: 0.1, distance: 30 mm}}
sliders:
  yoke: {joint: B, axis: [O, 0 deg], mass: 1.4}
  pin:  {joint: A, on: yoke, axis: [B, 90 deg]}
drives: {crank: {angle: 0, speed: 100}}
simulate: {end: 0.06283185307179587, samples: 101}
"""
