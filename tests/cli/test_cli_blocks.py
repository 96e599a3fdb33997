"""What the command line says of a slider with room in its guide."""

import pytest

from linkages import loads

TEXT = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.1}, rod: {joints: [A, B], length: 0.3}}
sliders: {piston: {joint: B, through: O, mass: 0.5, inertia: 1e-3}}
clearances:
  play: {slider: piston, size: 1 mm, length: 60 mm, height: 40 mm, contact: hertz, stiffness: 1e9,
         offset: 1.1 mm}
drives: {crank: {angle: 0.3, speed: 5}}
assembly: {B: [0.39, 0]}
simulate: {end: 0.01, samples: 101}
"""


def words(text):
    return " ".join(text.split())


def test_check_lists_the_contact_and_doubts_its_start(cli, tmp_path):
    loads(TEXT).save(tmp_path / "play.yaml")
    said = words(cli("check", "play.yaml").out)
    assert "mobility 3 by the Chebychev–Grübler–Kutzbach criterion, 3 by the rank" in said
    assert "free: play.offset, play.tilt" in said
    assert "contact piston in its guide hertz, stiffness 1e+09 N/m^1.5 clearances.play" in said
    assert "clearance play starts pressed in by 0.0001 m" in said


@pytest.mark.slow
def test_simulate_draws_the_block_and_tells_of_its_corners(cli, tmp_path):
    loads(TEXT).save(tmp_path / "play.yaml")
    result = cli("simulate", "play.yaml")
    assert result.code == 0
    assert "clearance play.corner1: " in words(result.out)
    drawn = {name.rpartition("/")[2] for name in result.files}
    assert {"clearance_orbit.png", "clearance_state.png", "mechanism.png"} <= drawn
