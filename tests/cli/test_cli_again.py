"""What commands write is computed again by `linkages.open`, bit for bit."""

import numpy as np
import pytest

import linkages

DRIVEN = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
free: {rod: {angle: 0.5, speed: 0}}
dampers: [{joint: O, damping: 0.3}]
loads: [{bar: rod, torque: {harmonic: {amplitude: 1.0, frequency: 0.5}}}]
simulate: {end: 1, samples: 11}
"""


COMMANDS = [
    "poincare --periods 3",
    "poincare --section rod.speed=0 --end 3 --periods 2",
    "lyapunov --periods 1",
    "map --x bars.rod.length=900mm:1000mm:2 --y free.rod.speed=0:1:2 --periods 4",
    "bifurcation --vary bars.rod.mass=1:2:2 --periods 3 --skip 0",
    "bifurcation --vary bars.rod.mass=1:2:2 --periods 3 --skip 0 --start both --store s"
    " --initial free.rod.angle=1,free.rod.speed=0 --initial free.rod.angle=0.2",
    "bifurcation --vary bars.rod.mass=1:2:3 --periods 2 --skip 0 --start backward",
    "sweep --measure max(rod.speed)/mean(rod.angle) --measure rms(rod.angle) --end 0.5 --store s"
    " --vary bars.rod.length=900mm,1000mm --sample free.rod.angle=normal(1,0.1) --draws 3 --seed 5",
    "sweep --measure max(rod.speed) --vary bars.rod.length=1:2:2,free.rod.angle=0:1:2"
    " --sample bars.rod.mass=uniform(1,2) --sequence sobol --draws 4",
    "simulate --set simulate.rtol=1e-7",
    "sensitivity --of max(rod.speed) --of rms(rod.angle) --to bars.* --end 0.5",
    "optimise --vary bars.rod.mass=1:1.2 --minimise max(abs(rod.acceleration)) --starts 2 --runs 8",
    "fit --to m.csv --vary dampers[0].damping=0:1 --sigma rod.angle=1deg",
]


@pytest.mark.slow_except("poincare --periods 3", "lyapunov*")
@pytest.mark.parametrize("command", COMMANDS)
def test_results_of_commands_are_computed_again_bit_for_bit(cli, tmp_path, command):
    (tmp_path / "driven.yaml").write_text(DRIVEN, encoding="utf-8")
    (tmp_path / "m.csv").write_text("time (s),rod.angle (deg)\n0.3,11\n0.7,-60\n1,-103\n")
    verb, *given = command.split()
    assert cli(verb, "driven.yaml", *given, "--out", "r", "--no-figures").code == 0
    (tmp_path / "m.csv").unlink()  # what was measured stands beside the fit
    opened = linkages.open(tmp_path / "r")
    assert opened.analysis == verb
    assert f"{verb} driven.yaml" in opened.command
    again = opened.compute()
    found = again.data if verb in ("simulate", "optimise", "fit") else again
    assert set(found.data_vars) == set(opened.data.data_vars)
    for name, values in opened.data.data_vars.items():
        floats = values.dtype.kind == "f"
        assert np.array_equal(values.to_numpy(), found[name].to_numpy(), equal_nan=floats), name
    for name, values in opened.data.coords.items():
        assert np.array_equal(values.to_numpy(), found[name].to_numpy()), name
