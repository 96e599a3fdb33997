"""Commands and their options.

What they do is `run` of the module of their name in `linkages.cli.verbs`.
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from linkages.cli.options import (
    Drawing,
    Figures,
    Format,
    Json,
    Moving,
    Out,
    Page,
    Picture,
    Processor,
    Start,
    Table,
    Template,
    complete_file,
)
from linkages.cli.verb import computes, reading
from linkages.errors import InputError, Problem
from linkages.options.analysis_options import (
    BifurcationOptions,
    ExponentOptions,
    MapOptions,
    SectionOptions,
    VerdictOptions,
)
from linkages.options.run import RunOptions, SimulationOptions
from linkages.spec.quantities import Bound, Quantity
from linkages.spec.units import DURATION, LENGTH

RANGE = "PATH=FIRST:LAST:COUNT"

Cores = Annotated[
    int | None, typer.Option(min=1, help="Computations at the same time; default: all cores.")
]

Device = Annotated[
    Processor,
    typer.Option(help="cuda: integrate motions on an NVIDIA graphics processor of this machine."),
]

Store = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Keep results there as they come; go on with them."),
]

Seed = Annotated[int, typer.Option(min=0, help="Of the draws.")]

Sequence = Annotated[
    Drawing, typer.Option(help="Independent draws, or those of a sequence that fills space.")
]

Scheduler = Annotated[
    str | None,
    typer.Option(metavar="tcp://HOST:PORT", help="Compute on the workers of a Dask scheduler."),
]

SIZE = reading(Quantity(LENGTH, Bound.POSITIVE))
SECONDS = reading(Quantity(DURATION))

Measures = Annotated[
    list[str] | None,
    typer.Option(
        metavar="MEASURE", help="A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable."
    ),
]


@computes(SimulationOptions)
def simulate(
    outputs: Annotated[
        str | None,
        typer.Option(
            help="Comma-separated variables to compute, or 'all'; default: kinematics, efforts."
        ),
    ] = None,
    verify: Annotated[
        bool | None,
        typer.Option(
            help="Integrate again at a tighter tolerance and say until when the answer holds; "
            "default: for adaptive methods of high order."
        ),
    ] = None,
    measure: Measures = None,
    units: Annotated[
        str | None, typer.Option(help="Units of the table instead of SI, e.g. 'mm,deg,rpm'.")
    ] = None,
    table: Annotated[Table, typer.Option(help="xlsx: a spreadsheet.")] = Table.CSV,
    reports: Annotated[
        list[Page] | None,
        typer.Option("--report", help="Write a report of one page as well (repeatable)."),
    ] = None,
) -> None:
    """Compute the motion; write simulate.nc, simulate.csv and figures; print maxima."""


@computes(without=("figures",))
def check(
    kernel: Annotated[
        bool, typer.Option("--kernel", help="Count the operations of the kernel.")
    ] = False,
    modes: Annotated[
        bool, typer.Option("--modes", help="List all ways to put the mechanism together.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="List the modes and draw them into this folder."),
    ] = None,
) -> None:
    """Report bodies, joints, loads, mobility, coordinates, blocks and condition numbers."""


@computes(without=("figures", "out"))
def equations(
    form: Annotated[
        str, typer.Option("--format", metavar="text|latex|python", help="How to print them.")
    ] = "text",
) -> None:
    """Print the closure equations, the energies and Lagrange's equations."""


@computes(SimulationOptions, without=("figures", "form"))
def export(
    to: Annotated[
        str, typer.Option("--to", metavar="FORMAT", help="c, python, javascript, mjcf, svg, dxf.")
    ],
    hole: Annotated[
        float | None,
        typer.Option(parser=SIZE, metavar="LENGTH", help="Diameter of holes at joints."),
    ] = None,
    width: Annotated[
        float | None,
        typer.Option(parser=SIZE, metavar="LENGTH", help="Width of links."),
    ] = None,
    paths: Annotated[bool | None, typer.Option(help="Write the paths of joints.")] = None,
    links: Annotated[bool | None, typer.Option(help="Write the outlines of links.")] = None,
    symbols: Annotated[
        bool | None, typer.Option("--symbols", help="Draw the mechanism as figures do.")
    ] = None,
) -> None:
    """Write the mechanism for another program: drawings at 1:1, programs, models."""


@computes(RunOptions, without=("figures",))
def animate(
    form: Annotated[
        Moving, typer.Option("--format", help="MP4 needs the program ffmpeg.")
    ] = Moving.GIF,
    start: Annotated[
        float,
        typer.Option(parser=SECONDS, metavar="<time>", help="Time of the first frame."),
    ] = 0.0,
    duration: Annotated[
        float | None,
        typer.Option(
            parser=SECONDS,
            metavar="<time>",
            help="How much of the motion to show; default: what can be seen.",
        ),
    ] = None,
    slow: Annotated[
        float | None,
        typer.Option(
            help="Seconds of the film per second of the motion, e.g. 10 for slow motion; "
            "default: what shows the fastest oscillation."
        ),
    ] = None,
    fps: Annotated[float, typer.Option(help="Frames per second.")] = 25.0,
    size: Annotated[
        str | None,
        typer.Option(metavar="WIDTHxHEIGHT", help="In pixels; default: as the mechanism needs."),
    ] = None,
    dpi: Annotated[
        float | None,
        typer.Option(help="Pixels per inch; default: texts and symbols grow with the size."),
    ] = None,
    names: Annotated[bool, typer.Option("--names", help="Write names beside joints.")] = False,
    plot: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Draw this over time below, e.g. 'crank.effort'."),
    ] = None,
    loads: Annotated[
        bool, typer.Option("--loads", help="Draw loads as large as they are at the time.")
    ] = False,
    reactions: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT", help="Draw the reaction of this joint, to the same scale."),
    ] = None,
    bare: Annotated[
        bool, typer.Option("--bare", help="Leave out axes and texts, as for small pictures.")
    ] = False,
) -> None:
    """Write an animation: the mechanism, traces of its joints, clearances enlarged."""


@computes(SimulationOptions, without=("figures",))
def view(
    outputs: Annotated[
        str | None,
        typer.Option(
            help="Comma-separated variables to show, or 'all'; default: kinematics, efforts, "
            "reactions, loads."
        ),
    ] = None,
    browser: Annotated[
        bool, typer.Option("--open", help="Open the page in the browser, too.")
    ] = False,
) -> None:
    """Write one HTML page that shows the motion and computes it again for other numbers."""


@computes(SimulationOptions)
def phase(
    x: Annotated[
        list[str], typer.Option(metavar="NAME", help="What to draw to the right, e.g. 'r1.angle'.")
    ],
    y: Annotated[
        list[str],
        typer.Option(metavar="NAME", help="What to draw upwards, e.g. 'slider9.velocity'."),
    ],
    wrap: Annotated[bool, typer.Option(help="Take angles within one turn.")] = True,
    skip: Annotated[
        float, typer.Option(parser=SECONDS, metavar="<time>", help="Left out at the start.")
    ] = 0.0,
    samples: Annotated[
        int | None, typer.Option(help="Points of the curve; default: simulate.samples, or 10001.")
    ] = None,
) -> None:
    """Draw any output of the motion against another one."""


@computes(SimulationOptions)
def plot(
    others: Annotated[
        list[str] | None,
        typer.Argument(metavar="[FILE]...", help="Others to draw with it; or results, run.nc."),
    ] = None,
    y: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="What to draw, e.g. 'rocker.angle'; repeatable."),
    ] = None,
    against: Annotated[
        str, typer.Option(metavar="NAME", help="What to draw it over, e.g. 'crank.angle'.")
    ] = "time",
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="PATH=A,B,…", help="A motion for each value, or PATH=FIRST:LAST:N."),
    ] = None,
    difference: Annotated[
        bool, typer.Option("--difference", help="Draw what the others differ in from the first.")
    ] = False,
    polar: Annotated[
        bool, typer.Option("--polar", help="Draw the tips of vectors, e.g. 'M.reaction'.")
    ] = False,
    wrap: Annotated[
        bool, typer.Option("--wrap", help="Take angles to the right within one turn.")
    ] = False,
) -> None:
    """Draw any outputs of one motion or several over each other, over time or a coordinate."""


@computes(SectionOptions)
def poincare(
    zoom: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LEFT,RIGHT,BOTTOM,TOP",
            help="A part to draw once more, larger, in units of the axes; repeatable.",
        ),
    ] = None,
) -> None:
    """Take a point of the motion every period of the drives, or at every crossing of a section."""


@computes(ExponentOptions)
def lyapunov() -> None:
    """Compute Lyapunov exponents: how fast neighbouring motions separate."""


@computes(BifurcationOptions)
def bifurcation(
    vary: Annotated[
        list[str],
        typer.Option(
            metavar=RANGE,
            help="What to vary, e.g. clearances.r1.size=0.01mm:0.5mm:200; several in lockstep.",
        ),
    ],
    start: Annotated[
        Start,
        typer.Option(help="From the file's state, or from the last state of the value before."),
    ] = Start.SAME,
    initial: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=VALUE,…", help="An initial state to try at every value; may be repeated."
        ),
    ] = None,
    store: Store = None,
    cores: Cores = None,
    device: Device = Processor.CPU,
) -> None:
    """Take section points for every value of a parameter."""


@computes(MapOptions)
def map_(
    x: Annotated[
        list[str], typer.Option(metavar=RANGE, help="Range to the right; several in lockstep.")
    ],
    y: Annotated[
        list[str], typer.Option(metavar=RANGE, help="Range upwards; several in lockstep.")
    ],
    store: Store = None,
    cores: Cores = None,
    device: Device = Processor.CPU,
) -> None:
    """Map an indicator of chaos over two parameters or a plane of initial states."""


@computes(SimulationOptions)
def sweep(
    measure: Measures = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=VALUES",
            help="An axis, e.g. clearances.r1.size=0.01mm:0.5mm:200 or bars.rod.length=1m,2m,5m; "
            "a grid if there are several.",
        ),
    ] = None,
    sample: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=DISTRIBUTION", help="Draw it, e.g. bars.rod.length=normal(40mm, 0.02mm)."
        ),
    ] = None,
    draws: Annotated[int | None, typer.Option(min=1, help="How often samples are drawn.")] = None,
    seed: Seed = 0,
    sequence: Sequence = Drawing.RANDOM,
    store: Store = None,
    time_per_point: Annotated[
        float | None,
        typer.Option(metavar="<time>", help="Seconds after which a point is given up."),
    ] = None,
    scheduler: Scheduler = None,
    status: Annotated[
        bool, typer.Option("--status", help="Say what the store FILE holds, and compute nothing.")
    ] = False,
    cores: Cores = None,
    device: Device = Processor.CPU,
) -> None:
    """Take measures of the motion at many values, alone, as a grid or drawn at random."""


@computes(SimulationOptions)
def sensitivity(
    of: Annotated[
        list[str],
        typer.Option(
            "--of",
            metavar="MEASURE",
            help="A number of the motion, e.g. 'max(abs(crank.effort))'; repeatable.",
        ),
    ],
    to: Annotated[
        list[str],
        typer.Option(
            "--to",
            metavar="PATH",
            help="A number of the definition, or a pattern such as 'bars.*'; repeatable.",
        ),
    ],
) -> None:
    """Say how measures change with numbers of the definition: exact derivatives, largest first."""


@computes(SimulationOptions)
def tolerance(
    of: Annotated[
        list[str],
        typer.Option(
            metavar="MEASURE",
            help="A number of the motion, e.g. 'max(abs(error(piston.position)))', where error is "
            "against the nominal mechanism; repeatable.",
        ),
    ],
    limits: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LIMITS",
            help="What a measure must keep to, e.g. 'stroke(piston.position) > 79.9 mm', for the "
            "yield; repeatable.",
        ),
    ] = None,
    draws: Annotated[
        int, typer.Option(min=100, help="Copies of the mechanism that are drawn.")
    ] = 10_000,
    seed: Seed = 0,
    sequence: Sequence = Drawing.RANDOM,
    store: Store = None,
    time_per_point: Annotated[
        float | None,
        typer.Option(metavar="<time>", help="Seconds after which a copy is given up."),
    ] = None,
    scheduler: Scheduler = None,
    cores: Cores = None,
) -> None:
    """Say what tolerances and clearances do to measures: contributions, worst case, yield."""


@computes(VerdictOptions)
def chaos(
    periods: Annotated[
        int | None, typer.Option(help="Length of the motion in periods; default: 300.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="200 periods, and 300 only if these do not decide.")
    ] = False,
) -> None:
    """Say whether the motion comes to rest, is periodic, quasi-periodic or chaotic, and why."""


@computes()
def bench(
    repeats: Annotated[int, typer.Option(min=1, help="Runs per point; the median counts.")] = 5,
) -> None:
    """Measure time against error of every method and of installed peers."""


COMMANDS = (
    simulate, check, equations, export, view, animate, plot, phase, poincare, lyapunov, bifurcation,
    map_, sweep, sensitivity, tolerance, chaos, bench,
)  # fmt: skip


Ranges = Annotated[
    list[str],
    typer.Option(
        metavar="PATH=FROM:TO", help="What to vary, e.g. bars.rod.length=120mm:160mm; repeatable."
    ),
]


class Search(StrEnum):
    """How far an optimum is looked for."""

    LOCAL = "local"
    GLOBAL = "global"


@computes(SimulationOptions)
def optimise(
    vary: Ranges,
    minimise: Annotated[
        str | None,
        typer.Option(metavar="MEASURE", help="What shall be least, e.g. 'max(abs(crank.effort))'."),
    ] = None,
    maximise: Annotated[
        str | None, typer.Option(metavar="MEASURE", help="What shall be greatest instead.")
    ] = None,
    subject_to: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COMPARISON",
            help="What must hold, e.g. 'min(transmission_angle) > 40 deg'; repeatable.",
        ),
    ] = None,
    search: Annotated[
        Search,
        typer.Option(help="From the file's numbers by derivatives, or all over the bounds."),
    ] = Search.LOCAL,
    starts: Annotated[int, typer.Option(min=1, help="Local searches from as many points.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Of these points, and of a global search.")] = 0,
    runs: Annotated[
        int | None, typer.Option(min=1, help="Motions after which the search ends.")
    ] = None,
    cores: Annotated[
        int | None, typer.Option(min=1, help="Computations at the same time; default: all cores.")
    ] = None,
) -> None:
    """Find the numbers that make a measure least or greatest; write optimised.yaml and figures."""


@computes(SimulationOptions)
def fit(
    to: Annotated[
        Path,
        typer.Option(
            metavar="CSV",
            help="Measurements: columns 'time (s)', 'crank.angle (deg)' and the like.",
        ),
    ],
    vary: Ranges,
    sigma: Annotated[
        list[str] | None,
        typer.Option(
            metavar="OUTPUT=VALUE",
            help="Standard deviation of an output, e.g. 'crank.angle=0.5 deg'; repeatable.",
        ),
    ] = None,
    starts: Annotated[int, typer.Option(min=1, help="Fits from as many points.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Of these points.")] = 0,
) -> None:
    """Find the numbers with which the motion goes as was measured, with their standard errors."""


DESIGN_COMMANDS = (optimise, fit)


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The file to write, a path or not.")],
    template: Annotated[
        Template, typer.Option(help="What it begins with.")
    ] = Template.SLIDER_CRANK,
    force: Annotated[bool, typer.Option("--force", help="Replace a file of that name.")] = False,
    json: Json = False,
) -> None:
    """Write a commented definition file to start from, and its schema for editors."""
    from linkages.cli.verbs.definition_commands import run_new

    raise typer.Exit(run_new(name, template, force, json))


def import_link(
    link: Annotated[
        str, typer.Argument(metavar="LINK", help="A share link of PMKS+; nothing is downloaded.")
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE", help="The definition file to write.")
    ] = Path("imported.yaml"),
    masses: Annotated[bool, typer.Option(help="Take the masses that the link has.")] = True,
    mass_per_length: Annotated[
        float, typer.Option(min=0.0, help="Of all bars in kg/m instead; plates: their outline.")
    ] = 0.0,
    clearance: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT=SIZE", help="Give a joint a clearance, e.g. B=0.1mm."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file of that name.")] = False,
    json: Json = False,
) -> None:
    """Write a definition file from a share link of PMKS+."""
    from linkages.cli.verbs.definition_commands import run_import

    raise typer.Exit(run_import(link, out, masses, mass_per_length, clearance or (), force, json))


def schema() -> None:
    """Print the JSON Schema of definition files."""
    from linkages.cli.verbs.definition_commands import run_schema

    raise typer.Exit(run_schema())


def list_mechanisms(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="Say what this one is, and draw it.",
            autocompletion=complete_file,
        ),
    ] = None,
    json: Json = False,
    out: Out = None,
    figures: Figures = True,
    form: Format = Picture.PNG,
    dimensions: Annotated[
        bool,
        typer.Option(
            "--dimensions", help="Draw lengths, the ground's frame and centres of mass, too."
        ),
    ] = False,
) -> None:
    """List the mechanisms that are shipped with the package, or show one of them."""
    from linkages.cli.verbs.library_command import run_list, run_show

    if name is None:
        for flag, given in (("--dimensions", dimensions), ("--out", out is not None)):
            if given:
                message = "expected the NAME of a mechanism to draw before this option"
                raise InputError(flag, [Problem(message=message)])
        raise typer.Exit(run_list(json))
    raise typer.Exit(run_show(name, out, json, figures, form.value, dimensions))
