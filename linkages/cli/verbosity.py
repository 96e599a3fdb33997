"""How much is said: ``--quiet`` and ``--verbose``."""

from __future__ import annotations

import logging
import sys

from linkages.cli.terminal import be_quiet

LOGGER = logging.getLogger("linkages")


def set_verbosity(quiet: bool, verbose: bool) -> None:
    """Print no reports, or what the package logs as well: files, kernels, integrations."""
    be_quiet(quiet)
    for handler in [h for h in LOGGER.handlers if isinstance(h, _Handler)]:
        LOGGER.removeHandler(handler)
    LOGGER.setLevel(logging.INFO if verbose else logging.NOTSET)
    if verbose:
        LOGGER.addHandler(_Handler())
        LOGGER.info("%s", _versions())


class _Handler(logging.StreamHandler):
    """Lines on standard error with the seconds since the start of the program."""

    def __init__(self) -> None:
        super().__init__(sys.stderr)
        self.setFormatter(_Formatter())


class _Formatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return f"{record.relativeCreated / 1000:7.2f} s  {record.getMessage()}"


def _versions() -> str:
    import platform
    from importlib.metadata import version

    return (
        f"linkages {version('linkages')}, Python {platform.python_version()}, "
        f"numba {version('numba')}, {platform.platform()}"
    )
