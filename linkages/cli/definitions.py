"""The verbs about definition files themselves: ``new``, ``schema`` and ``list``."""

from __future__ import annotations

from typing import Annotated

import typer

from linkages.cli.options import Figures, Format, Json, Out, Picture, Template, complete_file


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
) -> None:
    """List the mechanisms that are shipped with the package, or show one of them."""
    from linkages.cli.verbs.library import run_list, run_show

    raise typer.Exit(
        run_list(json) if name is None else run_show(name, out, json, figures, form.value)
    )
