"""Modules that plug-ins may import stay importable under the names that they had."""

import importlib
import subprocess
import sys

import pytest

from linkages.old_names import MOVED

GAS_STRUT = """
from linkages.components.contributed.component import component
from linkages.components.contributed.functions import Number, Operation
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.measures import Distance, Load, spring_law
from linkages.components.contributed.references import References
from linkages.components.spring import ends, two_joints
from linkages.components.contributed.terms import Path
from linkages.spec.quantities import Damping, Force, Name, PositiveLength, Stiffness
from linkages.components.mechanisms.schema import definition_schema
from linkages import Bar
from linkages.components import rigid_bodies
assert rigid_bodies.Bar is Bar
from linkages.components.springs import ends as same
assert same is ends
"""


@pytest.mark.parametrize("old", MOVED)
def test_an_old_name_is_the_same_module(old):
    sys.modules.pop(f"linkages.{old}", None)
    with pytest.warns(DeprecationWarning, match="goes with the next release"):
        found = importlib.import_module(f"linkages.{old}")
    assert found is importlib.import_module(f"linkages.{MOVED[old]}")
    assert found.__spec__.name == found.__name__ == f"linkages.{MOVED[old]}"


def test_imports_of_plug_ins_written_for_the_release_before():
    done = subprocess.run([sys.executable, "-c", GAS_STRUT], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_module_that_no_page_named_is_not_loaded_a_second_time():
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("linkages.solution.moving.guards")
