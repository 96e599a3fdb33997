"""Commands and their options, as `--help` has them.

A docstring says what a command does, and then what its own flags mean. What it does is `run_NAME`
of the module in `linkages.cli.verbs` that it names.
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
    ExponentOptions,
    MapOptions,
    SectionOptions,
    VerdictOptions,
    WearOptions,
)
from linkages.options.orbit_options import EquilibriumOptions, FollowOptions, OrbitOptions
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
    Folder, typer.Option(metavar="DIR", help="Keep results there as they come; go on with them.")
]
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
) -> None:
    """Compute the motion; write simulate.nc, simulate.csv and figures; print maxima.

    --outputs  Comma-separated variables to compute, or 'all'; default: kinematics, efforts.
    --verify  Integrate again at a tighter tolerance and say until when the answer holds;
        default: for adaptive methods of high order.
    --measure MEASURE  A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable.
    --units  Units of the table instead of SI, e.g. 'mm,deg,rpm'.
    --table  xlsx: a spreadsheet.
    --report  Write a report of one page as well (repeatable).
    """


@computes("check_commands", without=("figures",))
def check(
    kernel: bool = False,
    modes: bool = False,
    out: Annotated[Folder, typer.Option("--out")] = None,
) -> None:
    """Report bodies, joints, loads, mobility, coordinates, blocks and condition numbers.

    --kernel  Count the operations of the kernel.
    --modes  List all ways to put the mechanism together.
    --out DIR  List the modes and draw them into this folder.
    """


@computes("export_commands", without=("figures", "out"))
def equations(form: Language = "text") -> None:
    """Print the closure equations, the energies and Lagrange's equations.

    --format text|latex|python  How to print them.
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
    """Write the mechanism for another program: drawings at 1:1, programs, models.

    --to FORMAT  c, fmu, python, javascript, mjcf, svg, dxf.
    --hole LENGTH  Diameter of holes at joints.
    --width LENGTH  Width of links.
    --paths  Write the paths of joints.
    --links  Write the outlines of links.
    --symbols  Draw the mechanism as figures do.
    --fmi VERSION  Of the interface of an fmu: 3.0 or 2.0.
    --inputs NAME  Of an fmu, e.g. 'crank.torque', 'loads[0]', 'crank.acceleration'; repeatable.
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
    """Write an animation: the mechanism, traces of its joints, clearances enlarged.

    --format  MP4 needs the program ffmpeg.
    --start <time>  Time of the first frame.
    --duration <time>  How much of the motion to show; default: what can be seen.
    --slow  Seconds of the film per second of the motion, e.g. 10 for slow motion; default: what
        shows the fastest oscillation.
    --fps  Frames per second.
    --size WIDTHxHEIGHT  In pixels; default: as the mechanism needs.
    --dpi  Pixels per inch; default: texts and symbols grow with the size.
    --names  Write names beside joints.
    --plot NAME  Draw this over time below, e.g. 'crank.effort'.
    --loads  Draw loads as large as they are at the time.
    --reactions JOINT  Draw the reaction of this joint, to the same scale.
    --bare  Leave out axes and texts, as for small pictures.
    """


@computes("motion_commands", SimulationOptions, without=("figures",))
def view(
    outputs: str | None = None,
    browser: Annotated[bool, typer.Option("--open")] = False,
) -> None:
    """Write one HTML page that shows the motion and computes it again for other numbers.

    --outputs  Comma-separated variables to show, or 'all'; default: kinematics, efforts,
        reactions, loads.
    --open  Open the page in the browser, too.
    """


@computes("motion_commands", SimulationOptions)
def phase(
    x: list[str],
    y: list[str],
    wrap: bool = True,
    skip: Seconds = 0.0,
    samples: int | None = None,
) -> None:
    """Draw any output of the motion against another one.

    --x NAME  What to draw to the right, e.g. 'r1.angle'.
    --y NAME  What to draw upwards, e.g. 'slider9.velocity'.
    --wrap  Take angles within one turn.
    --skip <time>  Left out at the start.
    --samples  Points of the curve; default: simulate.samples, or 10001.
    """


@computes("motion_commands", SimulationOptions)
def plot(
    others: Annotated[
        Texts,
        typer.Argument(metavar="[FILE]...", help="Others to draw with it; or results, run.nc."),
    ] = None,
    y: Texts = None,
    against: str = "time",
    vary: Texts = None,
    difference: bool = False,
    polar: bool = False,
    wrap: bool = False,
) -> None:
    """Draw any outputs of one motion or several over each other, over time or a coordinate.

    --y NAME  What to draw, e.g. 'rocker.angle'; repeatable.
    --against NAME  What to draw it over, e.g. 'crank.angle'.
    --vary PATH=A,B,…  A motion for each value, or PATH=FIRST:LAST:N.
    --difference  Draw what the others differ in from the first.
    --polar  Draw the tips of vectors, e.g. 'M.reaction'.
    --wrap  Take angles to the right within one turn.
    """


@computes("section_commands", SectionOptions)
def poincare(zoom: Texts = None) -> None:
    """Take a point of the motion every period of the drives, or at every crossing of a section.

    --zoom LEFT,RIGHT,BOTTOM,TOP  A part to draw once more, larger, in units of the axes;
        repeatable.
    """


@computes("section_commands", ExponentOptions)
def lyapunov() -> None:
    """Compute Lyapunov exponents: how fast neighbouring motions separate."""


@computes("orbit_commands", OrbitOptions)
def orbit(state: Texts = None) -> None:
    """Find a periodic motion, stable or unstable, by Newton's method, and its multipliers.

    --state NAME=VALUE  Where the search begins, e.g. 'rod.angle=10 deg'; others are as in the
        file; repeatable.
    """


@computes("orbit_commands", FollowOptions)
def follow(
    vary: list[str],
    state: Texts = None,
    locus: str | None = None,
    other: Annotated[Texts, typer.Option("--and")] = None,
    store: Store = None,
) -> None:
    """Follow periodic motions or equilibria over a parameter, and locate special points.

    --vary PATH=FROM:TO  What to vary, e.g. clearances.gap.size=0.05mm:0.2mm; several change
        together.
    --state NAME=VALUE  Where the search begins, e.g. 'rod.angle=10 deg'; others are as in the
        file; repeatable.
    --locus LABEL  Follow this point of the branches, e.g. PD1, in two parameters.
    --and PATH=FROM:TO  The second parameter of a locus; several change together.
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
    """Find positions in which a mechanism rests, their stability, and vibration modes.

    --at <time>  Drives stand still where they are at this time; default: 0.
    --state NAME=VALUE  Where the search begins, or what --solve makes an equilibrium, e.g.
        'rod.angle=10 deg'; repeatable.
    --solve PATH  A number of the file to find, e.g. springs[0].length; one for each --state.
    --inputs NAME  Of the linear equations, e.g. 'rod.torque', 'P.x force', 'crank.acceleration';
        repeatable.
    --observed NAME  Output of the linear equations, e.g. 'rod.angle', 'crank.effort'; repeatable.
    --frequencies FROM:TO:COUNT  Of the frequency response, in Hz.
    --matrices  Write the linear equations of each equilibrium for NumPy or MATLAB, too.
    --film  Write a film of each mode.
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
    """Wear joints over many revolutions: clearances grow, and change the motion.

    --until PATH=SIZE  Where to end, e.g. 'clearances.gap.size = 0.5 mm'.
    --life  How long the joint lasts until then, over tolerances and uncertain wear rates.
    --draws  Copies of the mechanism that are drawn for its life; default: 30.
    --seed  Of the draws.
    --film  Write a film of the depth around journal and bearing.
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
    """Take section points for every value of a parameter.

    --vary PATH=FIRST:LAST:COUNT  What to vary, e.g. clearances.r1.size=0.01mm:0.5mm:200; several
        in lockstep.
    --start  From the file's state, or from the last state of the value before.
    --initial PATH=VALUE,…  An initial state to try at every value; may be repeated.
    --starts N  All attractors of so many random states instead, with hysteresis.
    --within PATH=FIRST:LAST  A side of the box that they are drawn from; repeatable; default: about
        the motion of the file.
    --seed  Of these states.
    """


@computes("sweep_commands", MapOptions)
def map_(
    x: list[str],
    y: list[str],
    loci: list[Path] | None = None,
    store: Store = None,
    cores: Cores = None,
    device: Device = "cpu",
) -> None:
    """Map an indicator of chaos over two parameters or a plane of initial states.

    --x PATH=FIRST:LAST:COUNT  Range to the right; several in lockstep.
    --y PATH=FIRST:LAST:COUNT  Range upwards; several in lockstep.
    --loci FILE  For 'period': draw the locus of a file that follow --locus wrote; repeatable.
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
    """Find all attractors of a plane or box of initial states, and draw their basins.

    --x PATH=FIRST:LAST:COUNT  Range to the right, e.g. free.rod.angle=-180deg:180deg:200.
    --y PATH=FIRST:LAST:COUNT  Range upwards, e.g. free.rod.speed=-10:10:200.
    --also PATH=FIRST:LAST:COUNT  A further range of initial states, for the shares; repeatable.
    --draws  States drawn at random from the box, for the shares.
    --seed  Of the draws.
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
    """Take measures of the motion at many values, alone, as a grid or drawn at random.

    --measure MEASURE  A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable.
    --vary PATH=VALUES  An axis, e.g. clearances.r1.size=0.01mm:0.5mm:200 or
        bars.rod.length=1m,2m,5m; a grid if there are several.
    --sample PATH=DISTRIBUTION  Draw it, e.g. bars.rod.length=normal(40mm, 0.02mm).
    --draws  How often samples are drawn.
    --seed  Of the draws.
    --time-per-point <time>  Seconds after which a point is given up.
    --status  Say what the store FILE holds, and compute nothing.
    """


@computes("design_commands", SimulationOptions)
def sensitivity(of: list[str], to: list[str]) -> None:
    """Say how measures change with numbers of the definition: exact derivatives, largest first.

    --of MEASURE  A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable.
    --to PATH  A number of the definition, or a pattern such as 'bars.*'; repeatable.
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
    """Say what tolerances and clearances do to measures: contributions, worst case, yield.

    --of MEASURE  A number of the motion, e.g. 'max(abs(error(piston.position)))', where error is
        against the nominal mechanism; repeatable.
    --limits LIMITS  What a measure must keep to, e.g. 'stroke(piston.position) > 79.9 mm', for
        the yield; repeatable.
    --draws  Copies of the mechanism that are drawn.
    --seed  Of the draws.
    --time-per-point <time>  Seconds after which a copy is given up.
    """


@computes("drive_commands")
def workspace(
    point: str | None = None,
    ranges: Annotated[Texts, typer.Option("--range", metavar="NAME=FROM:TO")] = None,
    samples: Annotated[int | None, typer.Option(min=5)] = None,
    own: bool | None = None,
) -> None:
    """Draw where two drives can move a point, and the singular curves there.

    --point JOINT  Whose workspace; default: the point that a drive moves, or the only free end.
    --range NAME=FROM:TO  Of a drive, or of an actuator where a drive moves the point, e.g.
        'crank=0:90 deg'; repeatable; default: a whole turn.
    --samples  Values of each driven coordinate from which curves are located; default: 181.
    --own  Only the assembly branch of the file, not all.
    """


@computes("drive_commands")
def duty(fluctuation: float | None = None, motors: Texts = None) -> None:
    """Say what drives must give over a cycle, size flywheels, and compare with motors.

    --fluctuation  Wanted coefficient of speed fluctuation, for flywheels of shafts, e.g. 0.02.
    --motors NAME=EFFORT,SPEED,RATIO  A motor of a drive: effort at standstill, speed without load,
        and perhaps the ratio of its gear, e.g. 'crank=30 N m, 1500 rpm, 5'; repeatable.
    """


@computes("section_commands", VerdictOptions)
def chaos(periods: int | None = None, quick: bool = False) -> None:
    """Say whether the motion comes to rest, is periodic, quasi-periodic or chaotic, and why.

    --periods  Length of the motion in periods; default: 300.
    --quick  200 periods, and 300 only if these do not decide.
    """


@computes("export_commands")
def bench(repeats: Count = 5) -> None:
    """Measure time against error of every method and of installed peers.

    --repeats  Runs per point; the median counts.
    """


@computes("design_commands", SimulationOptions)
def optimise(
    vary: list[str],
    minimise: str | None = None,
    maximise: str | None = None,
    subject_to: Texts = None,
    search: Literal["local", "global"] = "local",
    starts: Count = 1,
    seed: Seed = 0,
    runs: AtMost = None,
    cores: Cores = None,
) -> None:
    """Find the numbers that make a measure least or greatest; write optimised.yaml and figures.

    --vary PATH=FROM:TO  What to vary, e.g. bars.rod.length=120mm:160mm; repeatable.
    --minimise MEASURE  What shall be least, e.g. 'max(abs(crank.effort))'.
    --maximise MEASURE  What shall be greatest instead.
    --subject-to COMPARISON  What must hold, e.g. 'min(transmission_angle) > 40 deg'; repeatable.
    --search  From the file's numbers by derivatives, or all over the bounds.
    --starts  Local searches from as many points.
    --seed  Of these points, and of a global search.
    --runs  Motions after which the search ends.
    """


@computes("design_commands", SimulationOptions)
def fit(to: Path, vary: list[str], sigma: Texts = None, starts: Count = 1, seed: Seed = 0) -> None:
    """Find the numbers with which the motion goes as was measured, with their standard errors.

    --to CSV  Measurements: columns 'time (s)', 'crank.angle (deg)' and the like.
    --vary PATH=FROM:TO  What to vary, e.g. bars.rod.length=120mm:160mm; repeatable.
    --sigma OUTPUT=VALUE  Standard deviation of an output, e.g. 'crank.angle=0.5 deg'; repeatable.
    --starts  Fits from as many points.
    --seed  Of these points.
    """


@documented("definition_commands")
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The file to write, a path or not.")],
    template: Template = "slider-crank",
    force: bool = False,
    json: Json = False,
) -> None:
    """Write a commented definition file to start from, and its schema for editors.

    --template  What it begins with.
    --force  Replace a file of that name.
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
    """Write a definition file from a share link of PMKS+.

    --out FILE  The definition file to write.
    --masses  Take the masses that the link has.
    --mass-per-length  Of all bars in kg/m instead; plates: their outline.
    --clearance JOINT=SIZE  Give a joint a clearance, e.g. B=0.1mm.
    --force  Replace a file of that name.
    """


@documented("definition_commands")
def schema() -> None:
    """Print the JSON Schema of definition files."""


@documented("library_command")
def list_(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="Say what this one is, and draw it.", autocompletion=complete_file
        ),
    ] = None,
    json: Json = False,
    out: Out = None,
    figures: Figures = True,
    form: Format = "png",
    dimensions: bool = False,
) -> None:
    """List the mechanisms that are shipped with the package, or show one of them.

    --dimensions  Draw lengths, the ground's frame and centres of mass, too.
    """


COMMANDS = (
    simulate, check, equations, export, view, animate, plot, phase, poincare, lyapunov, orbit,
    follow, equilibrium, wear, bifurcation, map_, basins, sweep, sensitivity, tolerance, workspace,
    duty, chaos, bench, optimise, fit,
)  # fmt: skip
FILE_COMMANDS = (new, schema, import_, list_)
