"""What becomes of a definition: refused with words, run with finite numbers, or a fault.

Whatever a file says, reading, `check` and a short simulation end with a message, or with finite
numbers. Everything else is a fault of the program.
"""

import math
import signal
import traceback
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import process_time

import numpy as np

import linkages
from linkages.cli.verbs.check_commands import check_content
from linkages.components.mechanisms.definition import from_document
from linkages.errors import InputError, LinkagesError
from linkages.kernel.system import System
from linkages.reading.document import parse

SECONDS = 60.0
"""CPU time that a case may take; compiling the largest kernel takes some ten seconds."""
SAMPLES, STEPS = 12, 20_000
ADVANTAGES = ("mechanical_advantage", "slider_mechanical_advantage")
"""Infinite where a drive does not move a body, as the page on outputs says."""


class OverBudgetError(BaseException):
    """The case took too long; no handler of the program may swallow it."""


@dataclass
class Verdict:
    """``refused``, ``ran``, ``stopped``; or a fault: ``traceback``, ``endless``, ``silent``."""

    kind: str
    words: str = ""
    seconds: float = 0.0
    solution: linkages.Solution | None = field(default=None, repr=False)

    @property
    def fault(self):
        return self.kind in ("traceback", "endless", "silent")


def judge(text):
    """Read, check and run a definition."""
    begin = process_time()
    try:
        with budget(SECONDS):
            verdict = _tried(text)
    except OverBudgetError:
        verdict = Verdict("endless", f"more than {SECONDS:g} s of CPU time")
    except InputError as error:
        verdict = Verdict("refused", str(error))
    except Exception:
        verdict = Verdict("traceback", traceback.format_exc(limit=-4))
    verdict.seconds = process_time() - begin
    return verdict


def _tried(text):
    mechanism = from_document(parse(text, "m.yaml"))
    content = check_content(System(mechanism))
    defaults = mechanism.simulation
    samples = min(defaults.samples, SAMPLES)
    try:
        solution = linkages.simulate(
            mechanism, outputs="all", samples=samples, max_steps=STEPS, throw=False
        )
    except ValueError as error:
        return Verdict("refused", str(error)) if _said(error) else _raised(error)
    wrong = non_finite(solution.data)
    if wrong:
        return Verdict("silent", f"{wrong}; {solution.motion.failure}; {solution.notes}")
    wrong = _not_numbers(content)
    if wrong:
        return Verdict("silent", f"check: {wrong}")
    if solution.completed:
        return Verdict("ran", solution=solution)
    return Verdict("stopped", solution.motion.failure, solution=solution)


def _raised(error):
    return Verdict("traceback", "".join(traceback.format_exception(error, limit=-4)))


def _said(error):
    """Whether `simulate` refused its arguments itself, by a sentence about them."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return isinstance(error, LinkagesError) or "linkages/solution" in place.filename


def non_finite(data):
    """The variables of a dataset with numbers that are not finite."""
    found = []
    for name, variable in data.data_vars.items():
        values = variable.to_numpy()
        sound = ~np.isnan(values) if name in ADVANTAGES else np.isfinite(values)
        if not sound.all():
            found.append(name)
    return found


def _not_numbers(content, path=""):
    """Paths of numbers of a report that are not finite; a condition number may be infinite."""
    if isinstance(content, dict):
        return [p for key, inner in content.items() for p in _not_numbers(inner, f"{path}.{key}")]
    if isinstance(content, list):
        return [p for i, inner in enumerate(content) for p in _not_numbers(inner, f"{path}[{i}]")]
    wrong = isinstance(content, float) and not math.isfinite(content)
    return [path] if wrong and not path.endswith(".condition") else []


@contextmanager
def budget(seconds):
    """Raise `OverBudgetError` after a CPU time of this process; not on Windows, nor in threads."""

    def over(*_):
        raise OverBudgetError

    if not hasattr(signal, "ITIMER_PROF"):
        yield
        return
    before = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
