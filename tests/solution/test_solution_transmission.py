"""Transmission angles and mechanical advantages against closed forms, and what they are called."""

import numpy as np
import pytest

import linkages

CYLINDER = """\
joints: {O: [0, 0], D: [0.5, 0]}
bars: {boom: {joints: [O, P], length: 0.6, mass: 5}, cylinder: {joints: [D, T], length: 0.1}}
sliders: {rod: {joint: P, on: cylinder, through: D}}
drives: {rod: {position: 0.5, speed: 0.1}}
gravity: [0, -9.81]
assembly: {P: [0.3, 0.5]}
simulate: {end: 1, samples: 11}
"""


def test_transmission_angle_of_a_four_bar():
    """Law of cosines in the triangle of coupler, rocker and the line between their far ends."""
    mechanism = linkages.load("four-bar")
    data = linkages.simulate(mechanism, outputs=["transmission_angle", "joint_position"]).data
    place = {joint: data.joint_position.sel(joint=joint).to_numpy() for joint in ("A", "B", "O4")}
    a, b = (np.hypot(*(place[end] - place["B"]).T) for end in ("A", "O4"))
    across = np.hypot(*(place["A"] - place["O4"]).T)
    expected = np.arccos((a**2 + b**2 - across**2) / (2 * a * b))
    assert data.transmission_angle.sel(dyad="B").to_numpy() == pytest.approx(expected, abs=1e-13)


def test_transmission_and_advantage_of_a_slider_crank():
    mechanism = linkages.load("slider-crank")
    outputs = ["transmission_angle", "slider_mechanical_advantage", "bar_angle", "bar_speed",
               "slider_velocity", "mechanical_advantage"]  # fmt: skip
    data = linkages.simulate(mechanism, outputs=outputs).data
    rod = data.bar_angle.sel(bar="rod").to_numpy()
    # between the rod and the normal of the axis
    expected = np.arccos(np.abs(np.sin(rod)))
    found = data.transmission_angle.sel(dyad="piston").to_numpy()
    assert found == pytest.approx(expected, abs=1e-7)
    # Power is conserved: torque·speed of the crank is force·velocity of the piston.
    crank, piston = data.bar_speed.sel(bar="crank"), data.slider_velocity.sel(slider="piston")
    advantage = data.slider_mechanical_advantage.sel(drive="crank", slider="piston")
    moving = np.abs(piston.to_numpy()) > 1e-6
    ratio = (crank / piston).to_numpy()[moving]
    assert advantage.to_numpy()[moving] == pytest.approx(ratio, rel=1e-12)
    assert (data.mechanical_advantage.sel(bar="crank") == 1).all()


def test_a_drive_moves_what_it_does_not_move_with_infinite_advantage():
    data = linkages.simulate(linkages.load("ninebar-ideal"), outputs=["mechanical_advantage"]).data
    assert np.isinf(data.mechanical_advantage.sel(drive="crank1", bar="crank4")).all()
    assert not np.isnan(data.mechanical_advantage).any()


def test_units_of_a_driven_slider():
    mechanism = linkages.loads(CYLINDER)
    data = linkages.simulate(mechanism, outputs=["drive_effort", "mechanical_advantage"]).data
    assert data.drive_effort.attrs["units"] == "N"
    assert data.drive_effort.attrs["long_name"] == "driving force"
    assert data.mechanical_advantage.attrs["units"] == "m"
    turning = linkages.simulate(linkages.load("slider-crank"), outputs=["drive_effort"]).data
    assert turning.drive_effort.attrs["units"] == "N m"


def test_mechanical_advantage_is_what_a_bar_delivers():
    """Norton's crank-rocker: 2, 7, 9, 6 at 30°, ω₄/ω₂ = a sin(θ₂ − θ₃)/(c sin(θ₄ − θ₃)).

    A load of +5 N m on the rocker is held by −5 ω₄/ω₂ on the crank.
    """
    a, b, c, d, crank = 2.0, 7.0, 9.0, 6.0, np.radians(30)
    gap = d - a * np.exp(1j * crank)
    coupler = np.angle(gap) + np.arccos((abs(gap) ** 2 + b**2 - c**2) / (2 * abs(gap) * b))
    rocker = np.angle(a * np.exp(1j * crank) + b * np.exp(1j * coupler) - d)
    ratio = a * np.sin(crank - coupler) / (c * np.sin(rocker - coupler))
    found = linkages.loads("""
joints: {O2: [0, 0], O4: [6, 0]}
bars:
  crank: {joints: [O2, A], length: 2}
  coupler: {joints: [A, B], length: 7}
  rocker: {joints: [O4, B], length: 9}
drives: {crank: {angle: 30 deg, speed: 1}}
assembly: {B: left}
loads: [{bar: rocker, torque: 5}]
""")  # fmt: skip
    outputs = ["mechanical_advantage", "drive_effort", "bar_speed"]
    data = linkages.simulate(found, end=0.01, samples=2, outputs=outputs).data.isel(time=0)
    advantage = data.mechanical_advantage.sel(drive="crank", bar="rocker").item()
    assert advantage == pytest.approx(1 / ratio, rel=1e-12)
    assert advantage == pytest.approx(-2.505, abs=5e-4)
    assert data.bar_speed.sel(bar="rocker").item() == pytest.approx(ratio, rel=1e-12)
    assert data.drive_effort.item() == pytest.approx(-5 / advantage, rel=1e-12)
    assert data.mechanical_advantage.attrs["long_name"] == "mechanical advantage"
