"""Commands and their options, as `--help` has them.

A docstring describes the command, then its own flags, then two examples. The work is done by
`run_NAME` of the module in `linkages.cli.verbs` that the decorator names.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from linkages.cli.verb import (
    Figures,
    Format,
    Json,
    Out,
    Page,
    Template,
    complete_file,
    computes,
    documented,
    reading,
)
from linkages.options.analysis_options import (
    BasinOptions,
    BifurcationOptions,
    EquilibriumOptions,
    ExponentOptions,
    FollowOptions,
    MapOptions,
    OrbitOptions,
    SectionOptions,
    VerdictOptions,
    WearOptions,
)
from linkages.options.run import RunOptions, SimulationOptions
from linkages.spec.quantities import Bound, Quantity
from linkages.spec.units import DURATION, LENGTH

Texts = list[str] | None
Folder = Path | None
Size = Annotated[float | None, typer.Option(parser=reading(Quantity(LENGTH, Bound.POSITIVE)))]
Seconds = Annotated[float, typer.Option(parser=reading(Quantity(DURATION)))]
Count = Annotated[int, typer.Option(min=1)]
AtMost = Annotated[int | None, typer.Option(min=1)]
Seed = Annotated[int, typer.Option(min=0)]
Cores = Annotated[
    int | None, typer.Option(min=1, help="Computations at the same time; default: all cores.")
]
Device = Annotated[
    Literal["cpu", "cuda"],
    typer.Option(help="cuda: integrate motions on an NVIDIA graphics processor of this machine."),
]
Store = Annotated[
    Folder, typer.Option(metavar="DIR", help="Store results there as computed, and resume them.")
]
Branches = Literal["file", "all"]
Sequence = Annotated[
    Literal["random", "sobol", "latin-hypercube"],
    typer.Option(help="Independent draws, or those of a sequence that fills space."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="tcp://HOST:PORT", help="Compute on the workers of a Dask scheduler."),
]
Language = Annotated[str, typer.Option("--format")]


@computes("simulate_command", SimulationOptions)
def simulate(
    outputs: str | None = None,
    verify: bool | None = None,
    measure: Texts = None,
    units: str | None = None,
    table: Literal["csv", "xlsx"] = "csv",
    reports: Annotated[list[Page] | None, typer.Option("--report")] = None,
    curve: Texts = None,
) -> None:
    """Compute the motion: series, figures, and a table of extremes.

    --outputs  Comma-separated variables to compute, or 'all'; default: kinematics, efforts.
    --verify  Integrate again at a tighter tolerance; report until when the result holds;
        default: for adaptive methods of high order.
    --measure MEASURE  A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable.
    --units  Units of the table and of reports instead of SI, e.g. 'mm,deg,rpm'.
    --table  xlsx: a spreadsheet.
    --report  Write a report of one page as well (repeatable).
    --curve NAME  What a report draws, e.g. 'crank.effort'; repeatable; default: a choice.

    $ linkages simulate ninebar --set clearances.r1.size=0.2mm
    $ linkages simulate four-bar --end 2 --measure 'max(abs(crank.effort))'
    """


@computes("check_commands", without=("figures",))
def check(
    kernel: bool = False,
    modes: bool = False,
    out: Annotated[Folder, typer.Option("--out")] = None,
) -> None:
    """Check a file: bodies, joints, loads, mobility, assembly and its condition.

    --kernel  Count the operations of the kernel.
    --modes  List all assembly modes.
    --out DIR  List the assembly modes and draw them into this folder.

    $ linkages check ninebar
    $ linkages check four-bar --modes
    """


@computes("export_commands", without=("figures", "out"))
def equations(form: Language = "text") -> None:
    """Print closure equations, energies and Lagrange's equations.

    --format text|latex|python  How to print them.

    $ linkages equations slider-crank
    $ linkages equations four-bar --format latex
    """


@computes("export_commands", SimulationOptions, without=("figures", "form"))
def export(
    to: str,
    hole: Size = None,
    width: Size = None,
    paths: bool | None = None,
    links: bool | None = None,
    symbols: Annotated[bool | None, typer.Option("--symbols")] = None,
    fmi: str | None = None,
    inputs: Texts = None,
) -> None:
    """Export to another program: FMU, C, Python, JavaScript, MuJoCo, DXF, SVG.

    --to FORMAT  c, fmu, python, javascript, mjcf, svg, dxf.
    --hole LENGTH  Diameter of holes at joints.
    --width LENGTH  Width of links.
    --paths  Write the paths of joints.
    --links  Write the outlines of links.
    --symbols  Draw the mechanism with the symbols of figures.
    --fmi VERSION  Version of the interface of an fmu: 3.0 or 2.0.
    --inputs NAME  Input of an fmu, e.g. 'crank.torque', 'crank.acceleration'; repeatable.

    $ linkages export four-bar --to svg --hole 6mm
    $ linkages export ninebar --to fmu
    """


@computes("motion_commands", RunOptions, without=("figures",))
def animate(
    form: Annotated[Literal["gif", "webp", "mp4"], typer.Option("--format")] = "gif",
    start: Seconds = 0.0,
    duration: Annotated[float | None, typer.Option(parser=reading(Quantity(DURATION)))] = None,
    slow: float | None = None,
    fps: float = 25.0,
    size: str | None = None,
    dpi: float | None = None,
    names: bool = False,
    plot: Texts = None,
    loads: bool = False,
    reactions: Texts = None,
    bare: bool = False,
) -> None:
    """Make a film of the mechanism, with clearances magnified.

    --format  MP4 needs the program ffmpeg.
    --start <time>  Time of the first frame.
    --duration <time>  Length of the motion to show; default: as much as the eye can follow.
    --slow  Seconds of the film per second of the motion, e.g. 10 for slow motion; default: slow
        enough to show the fastest oscillation.
    --fps  Frames per second.
    --size WIDTHxHEIGHT  Size in pixels; default: from the shape of the mechanism.
    --dpi  Pixels per inch; default: texts and symbols grow with the size.
    --names  Write names beside joints.
    --plot NAME  Draw this series over time below, e.g. 'crank.effort'.
    --loads  Draw loads as arrows of their present size.
    --reactions JOINT  Draw the reaction of this joint, to the same scale.
    --bare  Leave out axes and texts, as for small pictures.

    $ linkages animate jansen
    $ linkages animate ninebar --start 0.1 --duration 0.03 --slow 100
    """


@computes("motion_commands", SimulationOptions, without=("figures",))
def view(
    outputs: str | None = None,
    browser: Annotated[bool, typer.Option("--open")] = False,
) -> None:
    """Write an interactive HTML page that animates, plots and simulates again.

    --outputs  Comma-separated variables to show, or 'all'; default: kinematics, efforts,
        reactions, loads.
    --open  Open the page in the browser, too.

    $ linkages view jansen --open
    $ linkages view ninebar --set clearances.r1.size=0.2mm
    """


@computes("motion_commands", SimulationOptions)
def phase(
    x: list[str],
    y: list[str],
    wrap: bool = True,
    skip: Seconds = 0.0,
    samples: int | None = None,
) -> None:
    """Draw a phase diagram of any two series.

    --x NAME  Series on the horizontal axis, e.g. 'r1.angle'.
    --y NAME  Series on the vertical axis, e.g. 'slider9.velocity'.
    --wrap  Wrap angles to one turn.
    --skip <time>  Time to leave out at the start.
    --samples  Points of the curve; default: simulate.samples, or 10001.

    $ linkages phase pendulum --x rod.angle --y rod.speed
    $ linkages phase ninebar --x r1.angle --y r1.speed --skip 0.5
    """


@computes("motion_commands", SimulationOptions)
def plot(
    others: Annotated[
        Texts,
        typer.Argument(metavar="[FILE]...", help="More files to draw, or results, run.nc."),
    ] = None,
    y: Texts = None,
    against: str = "time",
    vary: Texts = None,
    difference: bool = False,
    polar: bool = False,
    wrap: bool = False,
) -> None:
    """Plot any series over time or another series, of one motion or several.

    --y NAME  Series to draw, e.g. 'rocker.angle'; repeatable.
    --against NAME  Series on the horizontal axis, e.g. 'crank.angle'.
    --vary PATH=A,B,…  A motion for each value, or PATH=FIRST:LAST:N.
    --difference  Draw the differences of the others from the first.
    --polar  Draw the tips of vectors, e.g. 'M.reaction'.
    --wrap  Wrap angles on the horizontal axis to one turn.

    $ linkages plot four-bar --y rocker.angle --against crank.angle
    $ linkages plot slider-crank --y crank.effort --vary bars.rod.length=120mm,160mm
    """


@computes("section_commands", SectionOptions)
def poincare(zoom: Texts = None) -> None:
    """Compute a Poincaré section, stroboscopic or at crossings of a surface.

    --zoom LEFT,RIGHT,BOTTOM,TOP  A part to enlarge, in units of the axes; repeatable.

    $ linkages poincare ninebar-rotating --periods 100
    $ linkages poincare ninebar --section r1.speed=0
    """


@computes("section_commands", ExponentOptions)
def lyapunov() -> None:
    """Compute Lyapunov exponents with standard errors.

    $ linkages lyapunov double-pendulum
    $ linkages lyapunov ninebar --periods 50
    """


@computes("orbit_commands", OrbitOptions)
def orbit(state: Texts = None) -> None:
    """Find a periodic orbit, stable or not, and its Floquet multipliers.

    --state NAME=VALUE  Start of the search, e.g. 'rod.angle=10 deg'; other values are those of
        the file; repeatable.

    $ linkages orbit idling-engine
    $ linkages orbit impact-oscillator --set parameters.A=0.4
    """


@computes("orbit_commands", FollowOptions)
def follow(
    vary: list[str],
    state: Texts = None,
    locus: str | None = None,
    other: Annotated[Texts, typer.Option("--and")] = None,
    store: Store = None,
) -> None:
    """Continue orbits or equilibria over a parameter, and locate bifurcations.

    --vary PATH=FROM:TO  A parameter and its range, e.g. clearances.gap.size=0.05mm:0.2mm;
        several change together.
    --state NAME=VALUE  Start of the search, e.g. 'rod.angle=10 deg'; other values are those of
        the file; repeatable.
    --locus LABEL  Follow this point of the branches, e.g. PD1, in two parameters.
    --and PATH=FROM:TO  The second parameter of a locus; several change together.

    $ linkages follow impact-oscillator --vary parameters.A=0.1:0.8
    $ linkages follow idling-engine --vary loads[0].force=-20.8N:-18.2N --switch
    """


@computes("equilibrium_command", EquilibriumOptions, without=("at",))
def equilibrium(
    time: Annotated[float | None, typer.Option("--at", parser=reading(Quantity(DURATION)))] = None,
    state: Texts = None,
    solve: Texts = None,
    inputs: Texts = None,
    observed: Texts = None,
    frequencies: str | None = None,
    matrices: Literal["npz", "mat"] | None = None,
    film: bool | None = None,
) -> None:
    """Find equilibria, their stability, and vibration modes.

    --at <time>  Hold drives at their position at this time; default: 0.
    --state NAME=VALUE  Start of the search, or the equilibrium for --solve, e.g.
        'rod.angle=10 deg'; repeatable.
    --solve PATH  A parameter to solve for, e.g. springs[0].length; one for each --state.
    --inputs NAME  Input of the linear equations, e.g. 'rod.torque', 'P.x force',
        'crank.acceleration'; repeatable.
    --observed NAME  Output of the linear equations, e.g. 'rod.angle', 'crank.effort'; repeatable.
    --frequencies FROM:TO:COUNT  Frequencies of the response, in Hz.
    --matrices  Write the linear equations of each equilibrium for NumPy or MATLAB, too.
    --film  Write a film of each mode.

    $ linkages equilibrium pendulum
    $ linkages equilibrium double-pendulum --frequencies 0.1:10:200
    """


@computes("wear_command", WearOptions, without=("at",))
def wear(
    until: str | None = None,
    life: bool | None = None,
    draws: AtMost = None,
    seed: Annotated[int | None, typer.Option(min=0)] = None,
    film: bool | None = None,
    store: Store = None,
    cores: Cores = None,
) -> None:
    """Predict wear of joints over millions of revolutions, and their life.

    --until PATH=SIZE  Limit at which to end, e.g. 'clearances.gap.size = 0.5 mm'.
    --life  Compute how long joints last until then, with tolerances and uncertain wear rates.
    --draws  Copies of the mechanism that are drawn for its life; default: 30.
    --seed  Seed of the draws.
    --film  Write a film of the depth around journal and bearing.

    $ linkages wear worn.yaml --until 'clearances.gap.size = 0.5 mm'
    $ linkages wear worn.yaml --revolutions 1e6 --store study
    """


@computes("sweep_commands", BifurcationOptions)
def bifurcation(
    vary: list[str],
    start: Literal["same", "forward", "backward", "both"] = "same",
    initial: Texts = None,
    starts: AtMost = None,
    within: Texts = None,
    seed: Seed = 0,
    store: Store = None,
    cores: Cores = None,
    device: Device = "cpu",
) -> None:
    """Compute a bifurcation diagram over a parameter.

    --vary PATH=FIRST:LAST:COUNT  A parameter and its values, e.g.
        clearances.r1.size=0.01mm:0.5mm:200; several in lockstep.
    --start  From the file's state, or from the last state of the value before.
    --initial PATH=VALUE,…  An initial state to try at every value; may be repeated.
    --starts N  Find all attractors of so many random states instead, with hysteresis.
    --within PATH=FIRST:LAST  A side of the box from which to draw; repeatable; default: about
        the motion of the file.
    --seed  Seed of these states.

    $ linkages bifurcation ninebar --vary clearances.r1.size=0.05mm:0.5mm:100
    $ linkages bifurcation impact-oscillator --vary parameters.A=0.1:1:200 --starts 20
    """


@computes("sweep_commands", MapOptions)
def map_(
    x: list[str],
    y: list[str],
    loci: list[Path] | None = None,
    page: bool = False,
    store: Store = None,
    cores: Cores = None,
    device: Device = "cpu",
) -> None:
    r"""Map an indicator of chaos, or the period, over two parameters.

    --x PATH=FIRST:LAST:COUNT  Range of the horizontal axis; several in lockstep.
    --y PATH=FIRST:LAST:COUNT  Range of the vertical axis; several in lockstep.
    --loci FILE  For 'period': draw the locus in a file of follow --locus; repeatable.
    --page  For 'period': write map.html too, where a click on a point plays its motion.

    $ linkages map double-pendulum --x free.upper.angle=0:90deg:20 --y free.lower.angle=0:90deg:20
    $ linkages map impact-oscillator --indicator period --x parameters.A=0.1:1:40 \
          --y parameters.w=0.5:1.5:40
    """


@computes("basin_commands", BasinOptions)
def basins(
    x: list[str],
    y: list[str],
    also: Texts = None,
    draws: Annotated[int, typer.Option(min=0)] = 1000,
    seed: Seed = 0,
    store: Store = None,
    cores: Cores = None,
    device: Device = "cpu",
) -> None:
    r"""Find all attractors and their basins over initial states.

    --x PATH=FIRST:LAST:COUNT  Horizontal axis, e.g. free.rod.angle=-180deg:180deg:200.
    --y PATH=FIRST:LAST:COUNT  Vertical axis, e.g. free.rod.speed=-10:10:200.
    --also PATH=FIRST:LAST:COUNT  A further range of initial states, for the shares; repeatable.
    --draws  States drawn at random from the box, for the shares.
    --seed  Seed of the draws.

    $ linkages basins impact-oscillator --x free.mass.position=-2:1:40 --y free.mass.speed=-2:2:40
    $ linkages basins idling-engine --x clearances.gap.offset[0]=-0.1mm:0.1mm:20 \
          --y clearances.gap.offset[1]=-0.1mm:0.1mm:20
    """


@computes("sweep_commands", SimulationOptions)
def sweep(
    measure: Texts = None,
    vary: Texts = None,
    sample: Texts = None,
    draws: AtMost = None,
    seed: Seed = 0,
    sequence: Sequence = "random",
    store: Store = None,
    time_per_point: float | None = None,
    scheduler: Scheduler = None,
    status: bool = False,
    cores: Cores = None,
    device: Device = "cpu",
) -> None:
    r"""Evaluate measures while parameters vary: over ranges, on a grid, at random.

    --measure MEASURE  A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable.
    --vary PATH=VALUES  An axis, e.g. clearances.r1.size=0.01mm:0.5mm:200 or
        bars.rod.length=1m,2m,5m; a grid if there are several.
    --sample PATH=DISTRIBUTION  A random parameter, e.g. bars.rod.length=normal(40mm, 0.02mm).
    --draws  Number of draws.
    --seed  Seed of the draws.
    --time-per-point <time>  Seconds after which a point is abandoned.
    --status  Report the content of the store FILE, without computing.

    $ linkages sweep slider-crank --vary bars.rod.length=120mm:160mm:21 \
          --measure 'max(abs(crank.effort))'
    $ linkages sweep four-bar --sample 'bars.rocker.length=normal(80mm, 0.1mm)' \
          --draws 200 --measure 'range(rocker.angle)'
    """


@computes("design_commands", SimulationOptions)
def sensitivity(of: list[str], to: list[str]) -> None:
    """Differentiate measures with respect to parameters, exactly.

    --of MEASURE  A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable.
    --to PATH  A parameter of the definition, or a pattern such as 'bars.*'; repeatable.

    $ linkages sensitivity four-bar --of 'range(rocker.angle)' --to 'bars.*.length'
    $ linkages sensitivity slider-crank --of 'max(abs(crank.effort))' --to bars.rod.mass
    """


@computes("design_commands", SimulationOptions)
def tolerance(
    of: list[str],
    limits: Texts = None,
    draws: Annotated[int, typer.Option(min=100)] = 10_000,
    seed: Seed = 0,
    sequence: Sequence = "random",
    store: Store = None,
    time_per_point: float | None = None,
    scheduler: Scheduler = None,
    cores: Cores = None,
) -> None:
    r"""Analyse tolerances: contributions, worst case, yield.

    --of MEASURE  A number of the motion, e.g. 'max(abs(error(piston.position)))', where error is
        against the nominal mechanism; repeatable.
    --limits LIMITS  Limits of a measure, e.g. 'stroke(piston.position) > 79.9 mm', for
        the yield; repeatable.
    --draws  Copies of the mechanism that are drawn.
    --seed  Seed of the draws.
    --time-per-point <time>  Seconds after which a copy is abandoned.

    $ linkages tolerance four-bar --set 'bars.crank.length=40 ± 0.05 mm' --of 'range(rocker.angle)'
    $ linkages tolerance slider-crank --set 'bars.rod.length=140 ± 0.1 mm' \
          --of 'stroke(piston.position)' --draws 1000
    """


@computes("drive_commands")
def workspace(
    point: str | None = None,
    ranges: Annotated[Texts, typer.Option("--range", metavar="NAME=FROM:TO")] = None,
    samples: Annotated[int | None, typer.Option(min=5)] = None,
    own: bool | None = None,
) -> None:
    """Draw the workspace of a point, and its singular curves.

    --point JOINT  The point; default: the point that a drive moves, or the only free end.
    --range NAME=FROM:TO  Of a drive, or of an actuator if a drive moves the point, e.g.
        'crank=0:90 deg'; repeatable; default: a whole turn.
    --samples  Values of each driven coordinate from which curves are located; default: 181.
    --own  Draw only the assembly branch of the file.

    $ linkages workspace five-bar --point B
    $ linkages workspace five-bar --point B --range 'crank1=0:180 deg'
    """


@computes("drive_commands")
def duty(fluctuation: float | None = None, motors: Texts = None) -> None:
    """Compute the duty cycle of drives, size flywheels, and compare motors.

    --fluctuation  Coefficient of speed fluctuation to reach, for flywheels of shafts, e.g. 0.02.
    --motors NAME=EFFORT,SPEED,RATIO  A motor of a drive: torque at standstill, speed without load,
        and optionally the ratio of its gear, e.g. 'crank=30 N m, 1500 rpm, 5'; repeatable.

    $ linkages duty beam-pump
    $ linkages duty slider-crank --fluctuation 0.02
    """


@computes("section_commands", VerdictOptions)
def chaos(periods: int | None = None, quick: bool = False) -> None:
    """Classify a motion as at rest, periodic, quasi-periodic or chaotic.

    --periods  Length of the motion in periods; default: 300.
    --quick  200 periods, and 300 only if these do not decide.

    $ linkages chaos double-pendulum
    $ linkages chaos ninebar --quick
    """


@computes("export_commands")
def bench(repeats: Count = 5) -> None:
    """Benchmark time against error of every method on this mechanism.

    --repeats  Runs per point, of which the median is taken.

    $ linkages bench ninebar
    $ linkages bench double-pendulum --repeats 3
    """


@computes("design_commands", SimulationOptions)
def optimise(
    vary: list[str],
    minimise: str | None = None,
    maximise: str | None = None,
    subject_to: Texts = None,
    search: Literal["local", "global"] = "local",
    branches: Branches = "file",
    starts: Count = 1,
    seed: Seed = 0,
    runs: AtMost = None,
    cores: Cores = None,
) -> None:
    r"""Optimise parameters: minimise or maximise a measure under constraints.

    --vary PATH=FROM:TO  A parameter and its range, e.g. bars.rod.length=120mm:160mm; repeatable.
    --minimise MEASURE  The measure to minimise, e.g. 'max(abs(crank.effort))'.
    --maximise MEASURE  The measure to maximise instead.
    --subject-to COMPARISON  A constraint, e.g. 'min(transmission_angle) > 40 deg'; repeatable.
    --search  By derivatives from the values of the file, or over all of the bounds.
    --branches  all: search each assembly branch, and both senses of drives at constant speed.
    --starts  Number of points from which local searches start.
    --seed  Seed of these points, and of a global search.
    --runs  Motions after which the search ends.

    $ linkages optimise beam-pump --vary counterweights.weight.mass=0.5:6t \
          --minimise 'max(abs(crank.effort))'
    $ linkages optimise four-bar --vary bars.rocker.length=70mm:95mm \
          --maximise 'range(rocker.angle)' --subject-to 'min(transmission_angle) > 40 deg'
    """


@computes("design_commands", SimulationOptions)
def fit(
    to: Path,
    vary: list[str],
    sigma: Texts = None,
    subject_to: Texts = None,
    branches: Branches = "file",
    starts: Count = 1,
    seed: Seed = 0,
) -> None:
    r"""Fit parameters to measured data, with standard errors.

    --to CSV  Measurements: columns 'time (s)', 'crank.angle (deg)' and the like.
    --vary PATH=FROM:TO  A parameter and its range, e.g. bars.rod.length=120mm:160mm; repeatable.
    --sigma OUTPUT=VALUE  Standard deviation of an output, e.g. 'crank.angle=0.5 deg'; repeatable.
    --subject-to COMPARISON  A constraint, e.g. 'min(transmission_angle) > 40 deg'; repeatable.
    --branches  all: search each assembly branch, and both senses of drives at constant speed.
    --starts  Number of points from which fits start.
    --seed  Seed of these points.

    $ linkages fit four-bar --to measured.csv --vary bars.rocker.length=75mm:85mm
    $ linkages fit pendulum --to measured.csv --vary bars.rod.length=0.5:2 \
          --sigma 'rod.angle=0.5 deg'
    """


@documented("definition_commands")
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The file to write: name or path.")],
    template: Template = "slider-crank",
    force: bool = False,
    json: Json = False,
) -> None:
    """Create a commented definition file, and a schema for editors.

    --template  Content of the file.
    --force  Replace a file of that name.

    $ linkages new engine
    $ linkages new press/engine --template four-bar
    """


@documented("definition_commands")
def import_(
    link: Annotated[
        str, typer.Argument(metavar="LINK", help="A share link of PMKS+; nothing is downloaded.")
    ],
    out: Annotated[Path, typer.Option("--out")] = Path("imported.yaml"),
    masses: bool = True,
    mass_per_length: Annotated[float, typer.Option(min=0.0)] = 0.0,
    clearance: Texts = None,
    force: bool = False,
    json: Json = False,
) -> None:
    """Convert a share link of PMKS+ to a definition file.

    --out FILE  The definition file to write.
    --masses  Use the masses of the link.
    --mass-per-length  Mass of bars instead, in kg/m; plates: of their outline.
    --clearance JOINT=SIZE  Give a joint a clearance, e.g. B=0.1mm.
    --force  Replace a file of that name.

    $ linkages import 'https://app.pmksplus.com/?…' --out four.yaml
    $ linkages import 'https://app.pmksplus.com/?…' --mass-per-length 2 --clearance C=0.1mm
    """


@documented("definition_commands")
def schema() -> None:
    """Print the JSON Schema of definition files.

    $ linkages schema
    $ linkages schema > linkages.schema.json
    """


@documented("library_command")
def list_(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="Describe and draw this one.", autocompletion=complete_file
        ),
    ] = None,
    json: Json = False,
    out: Out = None,
    figures: Figures = True,
    form: Format = "png",
    dimensions: bool = False,
) -> None:
    """List the shipped mechanisms, or describe one.

    --dimensions  Draw lengths, the ground's frame and centres of mass, too.

    $ linkages list
    $ linkages list klann --dimensions
    """


PANELS = {
    "Simulate": (simulate, equilibrium, orbit, follow, wear),
    "Look": (check, equations, view, animate, plot, phase),
    "Analyse": (chaos, poincare, lyapunov, bifurcation, map_, basins),
    "Design": (sweep, sensitivity, tolerance, optimise, fit, workspace, duty),
    "Files and tools": (new, list_, export, import_, schema, bench),
}
"""Heading of the list of commands → commands, most of which compute with a file."""
