"""Numbers drawn at random: distributions, and draws that depend on seed, path and number alone."""

from __future__ import annotations

import hashlib
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from linkages.reading.wording import suggestion
from linkages.spec.arithmetic import NumberError, leading_number

Floats = NDArray[np.float64]

Sequenced = Literal["random", "sobol", "latin-hypercube"]
SEQUENCES = ("random", "sobol", "latin-hypercube")

SAMPLE = "bars.rod.length=normal(140 mm, 0.02 mm)"

_CALL = re.compile(r"\s*([a-z]+)\s*\((.*)\)\s*", re.DOTALL)
_TINY = 2.0**-54


def _normal(u: Floats, mean: float, deviation: float) -> Floats:
    from scipy.special import ndtri

    return np.asarray(mean + deviation * ndtri(u))


def _uniform(u: Floats, low: float, high: float) -> Floats:
    return low + (high - low) * u


def _triangular(u: Floats, low: float, mode: float, high: float) -> Floats:
    rising = (mode - low) / (high - low)
    left = low + np.sqrt(u * (high - low) * (mode - low))
    right = high - np.sqrt((1 - u) * (high - low) * (high - mode))
    return np.where(u < rising, left, right)


def _either(u: Floats, one: float, other: float) -> Floats:
    return np.where(u < 0.5, one, other)


_KINDS: Mapping[str, tuple[Callable[..., Floats], str]] = {
    "normal": (_normal, "mean, deviation"),
    "uniform": (_uniform, "low, high"),
    "triangular": (_triangular, "low, mode, high"),
    "either": (_either, "one, other"),
}
"""Name → inverse of the cumulative distribution, and what its numbers are."""


@dataclass(frozen=True)
class Distribution:
    """How a number is distributed.

    Parameters
    ----------
    text
        As it was written, or what tells it from others.
    inverse
        Probabilities → numbers in `unit`, shape (draws,) each.
    unit
        As the definition file would have it after the number; empty for SI.
    """

    text: str
    inverse: Callable[[Floats], Floats]
    unit: str = ""


@dataclass(frozen=True)
class _Inverse:
    """A named distribution with its numbers; can be sent to other processes."""

    name: str
    numbers: tuple[float, ...]

    def __call__(self, u: Floats) -> Floats:
        return _KINDS[self.name][0](u, *self.numbers)


@dataclass(frozen=True)
class _Frozen:
    """A frozen distribution of SciPy."""

    frozen: Any

    def __call__(self, u: Floats) -> Floats:
        return np.asarray(self.frozen.ppf(u), dtype=float)


def distribution_of(path: str, given: Any) -> Distribution:
    """A distribution from a text such as ``"normal(40 mm, 0.02 mm)"``, or a frozen one of SciPy.

    Raises
    ------
    ValueError
        If it is none.
    """
    if isinstance(given, Distribution):
        return given
    if isinstance(given, str):
        return _read(path, given)
    if callable(getattr(given, "ppf", None)):
        name, args, kwds = given.dist.name, given.args, given.kwds
        return Distribution(f"scipy {name} {args!r} {sorted(kwds.items())!r}", _Frozen(given))
    raise TypeError(f"{path}: expected values or a distribution, found {given!r}")


def is_distribution(given: Any) -> bool:
    """Whether something is a distribution and not a list of values."""
    named = isinstance(given, str) and _CALL.fullmatch(given) is not None
    return named or isinstance(given, Distribution) or hasattr(given, "ppf")


def _read(path: str, text: str) -> Distribution:
    match = _CALL.fullmatch(text)
    if match is None:
        raise ValueError(f"{path}: expected a distribution such as {SAMPLE}, found {text!r}")
    name, inner = match.groups()
    if name not in _KINDS:
        near = suggestion(name, _KINDS) or f"; expected one of: {', '.join(_KINDS)}"
        raise ValueError(f"{path}: unknown distribution {name!r}{near}")
    words = _KINDS[name][1]
    try:
        pairs = [leading_number(part) for part in inner.split(",")]
    except NumberError as error:
        raise ValueError(f"{path}: {name}({words}), found {text!r}: {error}") from None
    if len(pairs) != len(words.split(", ")):
        raise ValueError(f"{path}: expected {name}({words}), found {text!r}")
    units = {unit for _, unit in pairs}
    if len(units) > 1:
        raise ValueError(f"{path}: the numbers of {text!r} need the same unit")
    numbers = tuple(number for number, _ in pairs)
    wrong = numbers[1] <= 0 if name == "normal" else not _rising(numbers)
    if wrong:
        expected = "a deviation > 0" if name == "normal" else f"{words} in rising order"
        raise ValueError(f"{path}: expected {expected}, found {text!r}")
    return Distribution(" ".join(text.split()), _Inverse(name, numbers), units.pop())


def _rising(numbers: Sequence[float]) -> bool:
    inner = all(a <= b for a, b in pairwise(numbers))
    return inner and numbers[0] < numbers[-1]


def probabilities(
    paths: Sequence[str], draws: int, seed: int, sequence: Sequenced = "random"
) -> Floats:
    """Probabilities between 0 and 1 for each path, shape (paths, draws).

    Those of ``random`` are a function of seed, path and number of the draw alone: the blocks of
    Philox [1]_ under a key made of seed and path. Sequences depend on what else is drawn; a Latin
    hypercube on the number of draws as well.

    References
    ----------
    .. [1] J. K. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC11, 2011.
    """
    if sequence == "random":
        return np.array([_random(path, draws, seed) for path in paths])
    from scipy.stats import qmc

    kind = qmc.Sobol if sequence == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # balance needs powers of two: on the page
        found = kind(d=len(paths), seed=seed).random(draws).T
    return np.clip(found, _TINY, 1.0 - 2.0**-53)


def _random(path: str, draws: int, seed: int) -> Floats:
    digest = hashlib.sha256(f"{seed}\0{path}".encode()).digest()
    generator = np.random.Philox(key=np.frombuffer(digest[:16], dtype="<u8").copy())
    raw = generator.random_raw(4 * draws).reshape(draws, 4)[:, 0]  # a block of four for each draw
    return ((raw >> np.uint64(11)).astype(np.float64) + 0.5) * 2.0**-53
