"""Diagrams as they are written on the command line, and in the files of their results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from linkages.chaos.sweeps.bifurcation import bifurcation
from linkages.chaos.sweeps.diagram import put_together, ways
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.options.sections import BifurcationOptions
from linkages.options.signature import takes
from linkages.reading.overrides import NEXT, parse_assignment

if TYPE_CHECKING:
    import xarray as xr


@takes(BifurcationOptions)
def bifurcation_asked(
    mechanism: Mechanism,
    vary: Sequence[str],
    *,
    initial: Sequence[str] = (),
    **options: Any,
) -> xr.Dataset:
    """The diagram of a command: ranges and initial states are texts, and it may go both ways.

    Parameters
    ----------
    mechanism, vary
        As `linkages.bifurcation` takes them.
    initial
        ``PATH=VALUE,…`` for each initial state.
    options
        As `BifurcationOptions` describes them.
    """
    states: list[Mapping[str, object]] = [
        dict(map(parse_assignment, NEXT.split(text))) for text in initial
    ] or [{}]
    start = str(options.pop("start", "same"))
    parts = [
        bifurcation(mechanism, vary, start=one, initial=states, **options) for one in ways(start)
    ]
    return put_together(parts, start, states)
