"""Which method serves a tolerance best."""

from __future__ import annotations

from typing import NamedTuple

AUTO = "auto"
# Where the work–precision curves of tsit5 and vern9 cross, on pendulums, Arenstorf's orbit and
# the nine-bar: at rtol 3e-6 to 1e-4.
LOOSE = 1e-5


class Choice(NamedTuple):
    """A method's name, and why it is the one."""

    name: str
    reason: str


def choose(rtol: float, *, stiff: bool = False) -> Choice:
    """Pick an adaptive method by tolerance.

    Parameters
    ----------
    rtol
        Relative tolerance.
    stiff
        Whether stiff springs, dampers or oil films decide about the steps rather than accuracy.
        This is asked for, never guessed.
    """
    if stiff:
        return Choice(
            "radau", "stiffness was asked for: implicit steps are not bounded by stability"
        )
    if rtol >= LOOSE:
        return Choice(
            "tsit5",
            f"rtol {rtol:g} is loose: short steps of order 5 waste less than long ones of order 9",
        )
    return Choice(
        "vern9",
        f"rtol {rtol:g} is tight: for the same error on the nine-bar, order 9 takes 10 to 40 % "
        "fewer evaluations than order 8, and ever fewer than order 5",
    )
