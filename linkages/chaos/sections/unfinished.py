"""An analysis that could not be completed, with what was computed before."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from linkages.errors import ComputationError

if TYPE_CHECKING:
    import xarray as xr


class UnfinishedError(ComputationError):
    """An analysis ended early, since the motion could not go on.

    After Ctrl-C it is `linkages.Interrupted` that has what there is.

    Parameters
    ----------
    message
        When, where and why.
    kept
        Name of a result → what there is of it.
    time
        As of a `ComputationError`.
    """

    def __init__(
        self,
        message: str,
        kept: Mapping[str, xr.Dataset],
        *,
        time: float | None = None,
    ) -> None:
        super().__init__(message, time=time)
        self.kept = dict(kept)
