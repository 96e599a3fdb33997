"""The verbs that ask whether a motion is regular: ``poincare``, ``lyapunov`` and their kin."""

from __future__ import annotations

from typing import Annotated

import typer

from linkages.cli.options import (
    Cores,
    Crossing,
    Direction,
    Figures,
    File,
    Format,
    Indicator,
    Json,
    MaxSteps,
    Method,
    Out,
    Phase,
    Picture,
    Rtol,
    Section,
    Set,
    Start,
)


def phase(
    file: File,
    x: Annotated[
        str, typer.Option(metavar="NAME", help="What to draw to the right, e.g. 'r1.angle'.")
    ],
    y: Annotated[
        str, typer.Option(metavar="NAME", help="What to draw upwards, e.g. 'slider9.velocity'.")
    ],
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    wrap: Annotated[bool, typer.Option(help="Take angles within one turn.")] = True,
    skip: Annotated[float, typer.Option(help="Time in s that is left out at the start.")] = 0.0,
    end: Annotated[
        float | None, typer.Option(help="Simulated time in s; default: simulate.end.")
    ] = None,
    samples: Annotated[
        int | None, typer.Option(help="Points of the curve; default: simulate.samples, or 10001.")
    ] = None,
    method: Method = None,
    rtol: Rtol = None,
    form: Format = Picture.PNG,
) -> None:
    """Draw any output of the motion against another one."""
    from linkages.cli.phase import run_phase
    from linkages.cli.requests import Request

    request = Request(
        file=file, assignments=assignments or [], out=out, json=json,
        figures=figures, format=form.value, method=method, rtol=rtol,
    )  # fmt: skip
    raise typer.Exit(run_phase(request, x, y, wrap, skip, end, samples))


def poincare(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
    periods: Annotated[int, typer.Option(help="Number of points.")] = 500,
    skip: Annotated[int, typer.Option(help="Points left out before.")] = 0,
    phase: Phase = 0.0,
    section: Section = None,
    direction: Crossing = Direction.UP,
    wrap: Annotated[bool, typer.Option(help="Take angles within one turn.")] = True,
    end: Annotated[
        float | None, typer.Option(help="Time in s until which crossings are looked for.")
    ] = None,
    method: Method = None,
    rtol: Rtol = None,
) -> None:
    """Take a point of the motion every period of the drives, or at every crossing of a section."""
    from linkages.cli.poincare import run_poincare
    from linkages.cli.requests import Request

    request = Request(
        file=file, assignments=assignments or [], out=out, json=json,
        figures=figures, format=form.value, method=method, rtol=rtol,
    )  # fmt: skip
    raise typer.Exit(
        run_poincare(
            request,
            periods=periods,
            skip=skip,
            phase=phase,
            section=section,
            direction=direction.value,
            wrap=wrap,
            end=end,
        )
    )


def lyapunov(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
    periods: Annotated[int, typer.Option(help="Length of the run in periods.")] = 300,
    skip: Annotated[int, typer.Option(help="Periods before the average begins.")] = 0,
    count: Annotated[
        int | None, typer.Option(help="How many exponents, the largest; default: all.")
    ] = None,
    interval: Annotated[
        float | None,
        typer.Option(help="Length of a period in s; default: that of the drives, or simulate.end."),
    ] = None,
    method: Method = None,
    rtol: Rtol = None,
) -> None:
    """Compute Lyapunov exponents: how fast neighbouring motions separate."""
    from linkages.cli.lyapunov import run_lyapunov
    from linkages.cli.requests import Request

    request = Request(
        file=file, assignments=assignments or [], out=out, json=json,
        figures=figures, format=form.value, method=method, rtol=rtol,
    )  # fmt: skip
    raise typer.Exit(
        run_lyapunov(request, periods=periods, skip=skip, count=count, interval=interval)
    )


def bifurcation(
    file: File,
    vary: Annotated[
        list[str],
        typer.Option(
            metavar="PATH=FIRST:LAST:COUNT",
            help="What to vary, e.g. clearances.r1.size=0.01mm:0.5mm:200; several in lockstep.",
        ),
    ],
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
    periods: Annotated[int, typer.Option(help="Points at each value.")] = 200,
    skip: Annotated[int, typer.Option(help="Points left out before, at each value.")] = 100,
    phase: Phase = 0.0,
    section: Section = None,
    direction: Crossing = Direction.UP,
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
    exponent: Annotated[
        bool, typer.Option("--exponent", help="Compute the largest Lyapunov exponent as well.")
    ] = False,
    cores: Cores = None,
    max_steps: MaxSteps = None,
    method: Method = None,
    rtol: Rtol = None,
) -> None:
    """Take section points for every value of a parameter."""
    from linkages.cli.bifurcation import Sweep, run_bifurcation
    from linkages.cli.requests import Request

    request = Request(
        file=file, assignments=assignments or [], out=out, json=json,
        figures=figures, format=form.value, method=method, rtol=rtol,
    )  # fmt: skip
    sweep = Sweep(vary=vary, initial=initial or [], start=start.value, cores=cores)
    raise typer.Exit(
        run_bifurcation(
            request,
            sweep,
            periods=periods,
            skip=skip,
            phase=phase,
            section=section,
            direction=direction.value,
            exponent=exponent,
            max_steps=max_steps,
        )
    )


def map_(
    file: File,
    x: Annotated[
        list[str],
        typer.Option(
            metavar="PATH=FIRST:LAST:COUNT", help="Range to the right; several in lockstep."
        ),
    ],
    y: Annotated[
        list[str],
        typer.Option(metavar="PATH=FIRST:LAST:COUNT", help="Range upwards; several in lockstep."),
    ],
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
    indicator: Annotated[Indicator, typer.Option(help="What the map shows.")] = Indicator.EXPONENT,
    periods: Annotated[int, typer.Option(help="Length of each run in periods.")] = 100,
    cores: Cores = None,
    max_steps: MaxSteps = None,
    method: Method = None,
    rtol: Rtol = None,
) -> None:
    """Map an indicator of chaos over two parameters or a plane of initial states."""
    from linkages.cli.map import run_map
    from linkages.cli.requests import Request

    request = Request(
        file=file, assignments=assignments or [], out=out, json=json,
        figures=figures, format=form.value, method=method, rtol=rtol,
    )  # fmt: skip
    run = {"indicator": indicator.value, "periods": periods, "max_steps": max_steps}
    raise typer.Exit(run_map(request, x, y, cores, **run))


def chaos(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
    periods: Annotated[
        int | None, typer.Option(help="Length of the motion in periods; default: 300.")
    ] = None,
    skip: Annotated[
        int | None,
        typer.Option(help="Periods before it is judged; default: the transient, as it is found."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="As few periods as a verdict can rest on.")
    ] = False,
    method: Method = None,
    rtol: Rtol = None,
) -> None:
    """Say whether the motion comes to rest, is periodic, quasi-periodic or chaotic, and why."""
    from linkages.cli.chaos import run_chaos
    from linkages.cli.requests import Request

    request = Request(
        file=file, assignments=assignments or [], out=out, json=json,
        figures=figures, format=form.value, method=method, rtol=rtol,
    )  # fmt: skip
    raise typer.Exit(run_chaos(request, periods, quick, skip=skip))


def add_to(app: typer.Typer) -> None:
    """Make them verbs of the program."""
    for function in (phase, poincare, lyapunov, bifurcation, chaos):
        app.command()(function)
    app.command("map")(map_)
