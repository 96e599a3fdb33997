"""The linkages that the tests of this folder compute, and what they have in common."""

from pathlib import Path

import numpy as np
import pytest

from linkages.components.mechanisms.definition import from_document, load
from linkages.errors import InputError
from linkages.kernel.code.program import Program, write_program
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.reading.document import parse

DATA = Path(__file__).parents[1] / "data"
FOLDER = DATA / "linkages"
NAMES = sorted(file.stem for file in FOLDER.glob("*.yaml"))
LOOPED = [name for name in NAMES if "pendulum" not in name]


def text_of(name: str) -> str:
    return (FOLDER / f"{name}.yaml").read_text(encoding="utf-8")


def system(name: str, **numbers: object) -> System:
    return System(load(FOLDER / f"{name}.yaml", set=numbers or None))


def system_of(text: str) -> System:
    return System(from_document(parse(text, "m.yaml")))


def refusal(text: str) -> str:
    """What is wrong with a definition that has one problem."""
    with pytest.raises(InputError) as caught:
        system_of(text)
    (problem,) = caught.value.problems
    return str(problem)


def program(of: System) -> Program:
    """Printed from equations of its own: those of a system are shared with other tests."""
    model = Model(of.topology)
    return write_program(model, model.free_accelerations)


def values(of: System, name: str, time=0.0, state=None, acceleration=None) -> np.ndarray:
    """An output variable, shape (elements, times)."""
    return of.evaluate(VARIABLES[name].evaluated(of.model), time, state, acceleration)
