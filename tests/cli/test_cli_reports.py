"""Each command as a row: what it prints first, the keys of its JSON, and the files it writes."""

import json
import shlex

import pytest

PENDULUM = """\
name: Driven pendulum
gravity: [0, -1]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1 ± 0.01}}
masses: {P: 1 kg}
dampers: [{joint: O, damping: 0.5}]
loads: [{bar: arm, torque: "1.15*cos(2*t/3)"}]
free: {arm: {angle: -1.2, speed: 0}}
simulate: {end: 1, samples: 11, rtol: 1e-8}
"""
MEASURED = "time (s),arm.angle (deg)\n0,-68.7\n0.5,-55\n1,-25\n"
SWEEP = "sweep m.yaml --measure max(kinetic_energy) --vary masses.P=1,2 --cores 1"

# command | first line | keys of JSON | files: in results/m those without a folder
COMMANDS = {
    "simulate m.yaml": (
        "11 samples to t = 1 s, dop853, rtol 1e-08, 0 rejected, 4 steps, 68 evaluations",
        "completed stopped samples method reason cost horizon maxima measures notes files",
        "simulate.nc simulate.csv mechanism.png traces.png phase.png bar_angle.png bar_speed.png "
        "load_torque.png",
    ),
    "check m.yaml --kernel --modes": (
        "",
        "bodies joints revolute_pairs prismatic_pairs loops mobility driven free dependent blocks "
        "redundant relations drives loads notes kernel modes",
        "",
    ),
    "equations m.yaml": ("", "format equations", ""),
    "export m.yaml --to c": ("as c", "format bytes notes files", "m.c m.h"),
    "view m.yaml": (
        "11 samples from t = 0 s to 1 s, 14 outputs",
        "completed stopped bytes notes files",
        "view.html",
    ),
    "animate m.yaml --fps 5 --duration 0.4": (
        "20 frames from t = 0 s to 0.38 s, 5 per second, slowed down 10×",
        "completed stopped start last frames fps slow slow_clearances swings seconds bytes notes "
        "files",
        "animation.gif",
    ),
    "phase m.yaml --x time --y arm.angle": (
        "phase diagram",
        "stopped series files",
        "phase_time_arm.angle.nc phase_time_arm.angle.csv phase_time_arm.angle.png",
    ),
    "plot m.yaml --y arm.angle --vary masses.P=1,2": (
        "over time",
        "stopped series files",
        "plot_arm.angle.csv plot_arm.angle.png",
    ),
    "poincare m.yaml --periods 3": (
        "3 points, one per period of 9.42478 s, from t = 0 s to 18.8496 s",
        "points taken first last coordinates contact warning files",
        "poincare.nc poincare.csv poincare.png",
    ),
    "lyapunov m.yaml --periods 16 --count 1": (
        "Lyapunov exponents up to t = 150.796 s",
        "end periods period exponents sum lost least_touch certificate contact settled warning "
        "files",
        "lyapunov.nc lyapunov.csv lyapunov.png",
    ),
    "bifurcation m.yaml --vary dampers[0].damping=0.5:1:2 --periods 2 --cores 1": (
        "2 values of dampers[0].damping from 0.5 to 1 N m s/rad",
        "varied starts interrupted values failures warnings contact files",
        "bifurcation.nc bifurcation.csv bifurcation_values.csv bifurcation.png "
        "bifurcation_rates.png",
    ),
    "map m.yaml --x dampers[0].damping=0.5:1:2 --y free.arm.angle=0:1:2 --periods 4 "
    "--indicator fli --cores 1": (
        "4 of 4 points, dampers[0].damping and free.arm.angle",
        "indicator long_name units x y points computed interrupted least greatest signs rotation "
        "touches contact failures files",
        "map.nc map.csv map.png map_rotation.png",
    ),
    SWEEP: (
        "2 of 2 points, 2 values of masses.P",
        "points computed interrupted outcomes measures evaluations failures files",
        "sweep.nc sweep.csv sweep.png",
    ),
    "sensitivity m.yaml --of max(kinetic_energy) --to bars.*": (
        "max(kinetic_energy) = 0.106516 J",
        "measures files",
        "sensitivity.nc sensitivity.csv sensitivity.png sensitivity_curves.png",
    ),
    "tolerance m.yaml --of max(kinetic_energy) --draws 100": (
        "100 of 100 draws",
        "draws computed interrupted outcomes measures yields remarks failures files",
        "tolerance.nc tolerance.csv tolerance.png",
    ),
    "chaos m.yaml --quick": (
        "chaotic",
        "source verdict reasons conservative exponents errors settled sum lost power certificate "
        "zero_one lines rotation mean_rates dimension period phases closed_curves horizon contact "
        "tighter run notes files",
        "chaos.json chaos.html chaos_section.nc chaos_exponents.nc chaos_section.png "
        "chaos_exponents.png chaos_spectrum.png",
    ),
    "optimise m.yaml --vary bars.arm.length=0.5:2 --minimise max(kinetic_energy)": (
        "minimise max(kinetic_energy), 4 runs",
        "goal start optimum units runs runs_missing search plateau optimality variant notes "
        "numbers constraints files",
        "optimised.yaml optimise.nc optimise.csv optimise_convergence.png optimise_curves.png",
    ),
    "fit m.yaml --to measured.csv --vary bars.arm.length=0.5:2": (
        "3 values, ",  # the number of runs depends on the last digits of the processor
        "values runs numbers correlation chi_square degrees_of_freedom probability sigma_known "
        "variant notes files",
        "fitted.yaml fit.nc fit.csv fit.png",
    ),
    "entropy m.yaml --periods 200": ("", "rows warning files", "entropy.nc entropy.csv"),
    "bench m.yaml --repeats 1": (
        "to t = 1 s",
        "end machine reference_uncertainty seconds_per_evaluation costs seconds_at_error points "
        "files",
        "bench.json work_precision.png",
    ),
    "list": ("Mechanisms shipped with the package", "mechanisms", ""),
    "list pendulum": (
        "Pendulum",
        "file description components mobility driven free files",
        "results/pendulum/drawing.png",
    ),
    "new engine --force": (
        "wrote engine.yaml, a commented starter file, and linkages.schema.json",
        "template files",
        "./engine.yaml ./linkages.schema.json",
    ),
}
NAMELESS = {"export m.yaml --to c", "list", "new engine --force"}
"""Their JSON is of no mechanism."""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "m.yaml").write_text(PENDULUM, encoding="utf-8")
    (tmp_path / "measured.csv").write_text(MEASURED, encoding="utf-8")
    return tmp_path


@pytest.mark.slow_except(
    *(f"{verb} *" for verb in ("check", "equations", "export", "phase", "poincare", "lyapunov",
      "sweep", "sensitivity", "fit", "new"))
)  # fmt: skip
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_prints_a_report_and_writes_files(command, cli, folder):
    first, keys, names = COMMANDS[command]
    shown = cli(*shlex.split(command))
    assert (shown.code, shown.err) == (0, "")
    assert first in shown.out.splitlines()[0]
    made = {path for path in map(str, shown.files) if (folder / path).is_file()}
    places = [name if "/" in name else f"results/m/{name}" for name in names.split()]
    assert made - {"m.yaml", "measured.csv"} == {name.removeprefix("./") for name in places}
    content = json.loads(cli(*shlex.split(command), "--json").out)
    of = [] if command in NAMELESS else ["mechanism"]
    assert list(content) == [*of, *keys.split()]
    if "files" in content:
        assert set(content["files"]) == made - {"m.yaml", "measured.csv"}


@pytest.mark.usefixtures("folder")
def test_what_a_store_holds_is_a_report_without_a_mechanism(cli):
    assert cli(*shlex.split(SWEEP), "--store", "study", "--no-figures").code == 0
    assert cli("sweep", "study", "--status").out.startswith("study: 2 of 2 points, finished\n")
    content = json.loads(cli("sweep", "study", "--status", "--json").out)
    assert list(content) == [
        "store", "version", "points", "done", "left", "finished", "outcomes", "reasons",
    ]  # fmt: skip
