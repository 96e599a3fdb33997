"""The commands for definition files themselves: ``new``, ``schema`` and ``list``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from linkages.cli.options import Figures, Format, Json, Out, Picture, Template, complete_file
from linkages.errors import InputError, Problem


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The file to write, a path or not.")],
    template: Annotated[
        Template, typer.Option(help="What it begins with.")
    ] = Template.SLIDER_CRANK,
    force: Annotated[bool, typer.Option("--force", help="Replace a file of that name.")] = False,
    json: Json = False,
) -> None:
    """Write a commented definition file to start from, and its schema for editors."""
    from linkages.cli.verbs.new import run_new

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
    from linkages.cli.verbs.imported import run_import

    raise typer.Exit(run_import(link, out, masses, mass_per_length, clearance or (), force, json))


def schema() -> None:
    """Print the JSON Schema of definition files."""
    from linkages.cli.verbs.schema import run_schema

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
    from linkages.cli.verbs.library import run_list, run_show

    if name is None:
        for flag, given in (("--dimensions", dimensions), ("--out", out is not None)):
            if given:
                message = "expected the NAME of a mechanism to draw before this option"
                raise InputError(flag, [Problem(message=message)])
        raise typer.Exit(run_list(json))
    raise typer.Exit(run_show(name, out, json, figures, form.value, dimensions))
