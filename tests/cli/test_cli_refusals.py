"""What commands refuse: one clear message, its exit code, nothing printed and nothing written."""

import shlex

import pytest
from shared_definitions import DRIVEN_PENDULUM

PENDULUM = DRIVEN_PENDULUM + "simulate: {end: 10, samples: 11, rtol: 1e-8}\n"
EFFORT = "--measure max(abs(crank.effort))"
ROD = "--vary bars.rod.length=20mm:150mm:5"
SURE = "--set 'bars.crank.length=40 ± 0.02 mm' --set 'bars.rod.length=140 ± 0.05 mm'"
LONGEST = "--maximise stroke(piston.position) --subject-to min(transmission_angle)>75deg"
BEST = "optimise slider-crank --samples 51"
STROKE = "--of stroke(piston.position)"
SPEEDS = "--vary drives.crank.speed=60rpm,120rpm"
VARY = "bifurcation m.yaml --vary dampers[0].damping"

REFUSED = [
    ("phase m.yaml --x arm.angl --y arm.speed", "did you mean 'arm.angle'"),
    ("phase m.yaml --x arm.angle --y arm.speed --skip 11", "skip must be"),
    ("poincare m.yaml --phase 1.5", "phase must be from 0 to below 1"),
    ("poincare m.yaml --end 5", "end = 5 s goes with a section"),
    ("poincare m.yaml --direction both", "direction 'both' goes with a section"),
    ("poincare m.yaml --section arm.speed=0 --phase 0.5", "phase 0.5 goes with points"),
    ("poincare m.yaml --section arm.speed=0 --end 0", "end must be a time in s > 0"),
    ("poincare m.yaml --section arm.speed=0 --end -5", "end must be a time in s > 0"),
    (f"{VARY}=1:2:2 --direction down", "goes with a sect"),
    ("poincare m.yaml --periods 0", "whole number > 0, found '0'"),
    ("poincare m.yaml --section am.speed=0", "did you mean 'arm.speed'"),
    ("poincare m.yaml --method dopr", "dopr"),
    ("poincare m.yaml --rtol -1", "rtol"),
    ("poincare m.yaml --set loads[0].torque=1.15", "geometric section"),
    ("lyapunov m.yaml --count 3", "count must be from 1 to 2"),
    (f"{VARY}=1", "expected a range such as"),
    (f"{VARY}=1:2:1", "at least two values"),
    ("bifurcation m.yaml --vary dumpers[0].damping=1:2:2", "dumpers"),
    (f"{VARY}=1:2:2 --initial x", "expected path=value"),
    (f"{VARY}=1:2:2 --initial fre.arm.angle=1", "fre"),
    (f"{VARY}=1:2:2 --section arm.s=0", "has no 's'"),
    (f"{VARY}=1:2:2 --phase 2", "phase must be"),
    (f"{VARY}=1:2:2 --vary masses.P=1:2:3", "equally many"),
    (f"{VARY}=1:2:2 --vary dampers[0].damping=2:3:2", "two ranges"),
    (f"{VARY}=-2:-1:2", "-2"),
    (
        "map m.yaml --x dampers[0].damping=1:2:2 --y dampers[0].damping=2:3:2",
        "varied by two ranges",
    ),
    ("map m.yaml --x dampers[0].damping=-2:-1:2 --y masses.P=1:2:2", "-2"),
    ("bifurcation m.yaml --vary loads[0].torque=1:2:2", "nothing depends on time"),
    ("map m.yaml --x dampers[0].damping=1:2:2 --y masses.P=1:2:2 --periods 1", "at least"),
    ("map m.yaml --x dampers[0].damping=1:2:2 --y masses.P", "expected a range such as"),
    ("chaos m.yaml --periods 3", "at least 200 periods"),
    ("chaos m.yaml --set bars.arm.length=-1", "bars.arm.length"),
    (f"sweep slider-crank {EFFORT}", "nothing is varied"),
    (f"sweep slider-crank {ROD}", "nothing is measured; expected 'max(crank.angle)'"),
    (f"sweep slider-crank {EFFORT} --vary bars.rodd.length=1:2:3", "did you mean 'rod'"),
    (f"sweep slider-crank --measure max(crank.efort) {ROD}", "did you mean 'crank.effort'"),
    (f"sweep slider-crank {EFFORT} --vary bars.rod.length=1:2:1", "at least two values"),
    (f"sweep slider-crank {EFFORT} --vary bars.rod.length=1:2:1000000000", "would take at least"),
    (f"sweep slider-crank {EFFORT} {ROD} --draws 5", "nothing is drawn"),
    (
        f"sweep slider-crank {EFFORT} --sample 'bars.rod.length=normal(1, 2)'",
        "need a number of draws",
    ),
    (
        f"sweep slider-crank {EFFORT} {ROD} --sample 'bars.rod.length=normal(1, 2)'",
        "expected one of them",
    ),
    (f"sweep slider-crank {EFFORT} {EFFORT} {ROD}", "given twice"),
    (f"sweep slider-crank {EFFORT} {ROD} --time-per-point 0", "time_per_point must be"),
    ("sensitivity slider-crank --of max(crank.efort) --to bars.*", "did you mean 'crank.effort'"),
    (
        "sensitivity slider-crank --of max(abs(crank.effort)) --to bars.rd.length",
        "did you mean 'bars.rod.length'",
    ),
    ("sensitivity slider-crank --of max(abs(crank.effort)) --to wheels.*", "fits this pattern"),
    (
        "sensitivity slider-crank --of crank.effort --to bars.*",
        "expected outputs within a reduction over time",
    ),
    (
        "sensitivity slider-crank --of max(abs(crank.effort)) --to bars.rod.joints",
        "found no number there",
    ),
    (f"tolerance slider-crank {STROKE}", "nothing varies: no number of the definition"),
    (
        f"tolerance slider-crank {SURE} --of stroke(pistom.position)",
        "did you mean 'piston.position'?",
    ),
    (f"tolerance slider-crank {SURE} {STROKE} --limits 3", "expected limits such as"),
    (
        f"tolerance slider-crank --set 'bars.rod.joints=[A ± 1, B]' {STROKE}",
        "only quantities have tolerances",
    ),
    (f"tolerance slider-crank --set 'bars.rad.length=1 ± 0.1 m' {STROKE}", "did you mean"),
    (f"tolerance slider-crank {SURE} {STROKE} --end '1 ± 0.1 s'", "options have no tolerance"),
    (
        f"{BEST} --vary bars.crank.length=10:60mm --minimise max(abs(crank.efort))",
        "did you mean 'crank.effort'?",
    ),
    (
        f"{BEST} --vary bars.crank.length=10:60mm",
        "expected one of minimise and maximise, found none",
    ),
    (f"{BEST} --vary bars.crank.length=10mm {LONGEST}", "expected a range such as"),
    (f"{BEST} --vary bars.crank.lenth=10:60mm {LONGEST}", "bars.crank.lenth"),
    (f"{BEST} --vary bars.crank.length=10:60mm {LONGEST} --search everywhere", "everywhere"),
    ("plot four-bar", "expected what to draw, such as --y crank.angle"),
    ("plot four-bar --y rocker.angel", "did you mean 'rocker.angle'"),
    ("plot four-bar --y bar_angle", "expected one of its series: crank.angle, coupler.angle"),
    ("plot four-bar --y rocker.rotation", "did you mean 'rocker.angle'"),
    ("plot four-bar --y rocker.angle --difference", "a difference needs two motions"),
    (
        f"plot four-bar --y crank.angle --against rocker.angle --difference {SPEEDS}",
        "rocker.angle goes back and forth",
    ),
    ("plot four-bar --y rocker.angle --polar", "rocker.angle has no direction"),
    ("plot four-bar --y B.velocity --polar --difference", "does not go with it"),
    ("plot four-bar --y rocker.angle --vary drives.crank.speed=1:2:13", "up to 12"),
    ("plot four-bar --y rocker.angle --vary drives.crank.sped=1,2", "did you mean"),
    (
        "phase four-bar --x crank.angle --y rocker.angle --y rocker.speed",
        "expected one series, found rocker.angle and rocker.speed; `plot` draws several",
    ),
    ("poincare m.yaml --periods 8 --zoom=1,2,3", "1,2,3"),
    ("poincare m.yaml --periods 8 --zoom=2,1,0,1", "2,1,0,1"),
    ("poincare m.yaml --periods 8 --zoom=0,5,nan,1", "0,5,nan,1"),
    ("poincare m.yaml --periods 8 --zoom=rod:0,1,0,1", "rod:0,1,0,1"),
    ("poincare four-bar", "nothing is free to move"),
    ("lyapunov four-bar", "nothing is free to move"),
    ("chaos four-bar", "nothing is free to move"),
]
FAILING = [
    (
        f"tolerance slider-crank {SURE} --of 1/(stroke(piston.position)-stroke(piston.position))",
        "divides by zero",
    ),
    (f"{BEST} --vary bars.rod.length=20:30mm {LONGEST}", "no feasible start"),
]


@pytest.mark.slow_except(
    *(f"{verb} *" for verb in ("phase", "map", "chaos", "plot", "sweep", "sensitivity",
      "tolerance", "optimise"))
)  # fmt: skip
@pytest.mark.parametrize(
    ("command", "message", "code"),
    [(*row, code) for code, rows in ((2, REFUSED), (1, FAILING)) for row in rows],
    ids=[command for command, _ in (*REFUSED, *FAILING)],
)
def test_a_request_is_refused_in_one_message(command, message, code, cli, tmp_path):
    (tmp_path / "m.yaml").write_text(PENDULUM)
    result = cli(*shlex.split(command))
    assert (result.code, result.out) == (code, "")
    assert message in " ".join(result.err.split())
    assert "Traceback" not in result.err
    assert result.files == {"m.yaml"}
