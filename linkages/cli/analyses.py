"""Commands that compute something: what they are asked for beyond what all of them are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from linkages.cli.options import Moving, Start
from linkages.cli.verb import computes
from linkages.options.exponents import ExponentOptions, MapOptions, VerdictOptions
from linkages.options.run import RunOptions, SimulationOptions
from linkages.options.sections import BifurcationOptions, SectionOptions

if TYPE_CHECKING:
    from linkages.cli.requests import Request

RANGE = "PATH=FIRST:LAST:COUNT"

Cores = Annotated[
    int | None, typer.Option(min=1, help="Computations at the same time; default: all cores.")
]


@computes(SimulationOptions)
def simulate(
    request: Request,
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
) -> int:
    """Compute the motion; write simulate.nc, simulate.csv and figures; print maxima."""
    from linkages.cli.verbs.simulate import run_simulate

    return run_simulate(request, outputs, verify)


@computes(without=("figures",))
def check(
    request: Request,
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
) -> int:
    """Report bodies, joints, loads, mobility, coordinates, blocks and condition numbers."""
    from linkages.cli.verbs.check import run_check

    return run_check(request, kernel, modes or out is not None)


@computes(without=("figures", "out"))
def equations(
    request: Request,
    form: Annotated[
        str, typer.Option("--format", metavar="text|latex|python", help="How to print them.")
    ] = "text",
) -> int:
    """Print the closure equations, the energies and Lagrange's equations."""
    from linkages.cli.verbs.equations import run_equations

    return run_equations(request, form)


@computes(RunOptions, without=("figures",))
def animate(
    request: Request,
    form: Annotated[
        Moving, typer.Option("--format", help="MP4 needs the program ffmpeg.")
    ] = Moving.GIF,
    start: Annotated[float, typer.Option(help="Time in s of the first frame.")] = 0.0,
    duration: Annotated[
        float | None, typer.Option(help="How much of the motion to show, in s; default: the rest.")
    ] = None,
    slow: Annotated[
        float | None,
        typer.Option(
            help="Seconds of the film per second of the motion, e.g. 10 for slow motion; "
            "default: 1, or what makes the film last from 4 to 12 s."
        ),
    ] = None,
    fps: Annotated[float, typer.Option(help="Frames per second.")] = 25.0,
    size: Annotated[
        str | None,
        typer.Option(metavar="WIDTHxHEIGHT", help="In pixels; default: as the mechanism needs."),
    ] = None,
    dpi: Annotated[float, typer.Option(help="Pixels per inch: size of texts and symbols.")] = 80.0,
) -> int:
    """Write a moving picture: the mechanism, traces of its joints, clearances enlarged."""
    from linkages.cli.verbs.animate import run_animate

    return run_animate(request, form, start, duration, slow, fps, size, dpi)


@computes(SimulationOptions)
def phase(
    request: Request,
    x: Annotated[
        str, typer.Option(metavar="NAME", help="What to draw to the right, e.g. 'r1.angle'.")
    ],
    y: Annotated[
        str, typer.Option(metavar="NAME", help="What to draw upwards, e.g. 'slider9.velocity'.")
    ],
    wrap: Annotated[bool, typer.Option(help="Take angles within one turn.")] = True,
    skip: Annotated[float, typer.Option(help="Time in s that is left out at the start.")] = 0.0,
    samples: Annotated[
        int | None, typer.Option(help="Points of the curve; default: simulate.samples, or 10001.")
    ] = None,
) -> int:
    """Draw any output of the motion against another one."""
    from linkages.cli.verbs.phase import run_phase

    return run_phase(request, x, y, wrap, skip, samples)


@computes(SectionOptions)
def poincare(request: Request) -> int:
    """Take a point of the motion every period of the drives, or at every crossing of a section."""
    from linkages.cli.verbs.poincare import run_poincare

    return run_poincare(request)


@computes(ExponentOptions)
def lyapunov(request: Request) -> int:
    """Compute Lyapunov exponents: how fast neighbouring motions separate."""
    from linkages.cli.verbs.lyapunov import run_lyapunov

    return run_lyapunov(request)


@computes(BifurcationOptions)
def bifurcation(
    request: Request,
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
    cores: Cores = None,
) -> int:
    """Take section points for every value of a parameter."""
    from linkages.cli.verbs.bifurcation import run_bifurcation

    return run_bifurcation(request, vary, start, initial or [], cores)


@computes(MapOptions)
def map_(
    request: Request,
    x: Annotated[
        list[str], typer.Option(metavar=RANGE, help="Range to the right; several in lockstep.")
    ],
    y: Annotated[
        list[str], typer.Option(metavar=RANGE, help="Range upwards; several in lockstep.")
    ],
    cores: Cores = None,
) -> int:
    """Map an indicator of chaos over two parameters or a plane of initial states."""
    from linkages.cli.verbs.map import run_map

    return run_map(request, x, y, cores)


@computes(VerdictOptions)
def chaos(
    request: Request,
    periods: Annotated[
        int | None, typer.Option(help="Length of the motion in periods; default: 300.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="As few periods as a verdict can rest on.")
    ] = False,
) -> int:
    """Say whether the motion comes to rest, is periodic, quasi-periodic or chaotic, and why."""
    from linkages.cli.verbs.chaos import run_chaos

    return run_chaos(request, periods, quick)


@computes()
def bench(
    request: Request,
    repeats: Annotated[int, typer.Option(min=1, help="Runs per point; the median counts.")] = 5,
) -> int:
    """Measure time against error of every method and of installed peers."""
    from linkages.cli.verbs.bench import run_bench

    return run_bench(request, repeats)


COMMANDS = (
    simulate, check, equations, animate, phase, poincare, lyapunov, bifurcation, map_, chaos, bench
)  # fmt: skip
