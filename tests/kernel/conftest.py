"""A graph of scalars that a test may add nodes to."""

import pytest

from linkages.kernel.scalars import Level, ScalarGraph


@pytest.fixture
def graph():
    return ScalarGraph()


@pytest.fixture
def inputs(graph):
    return [graph.input("y", k, Level.STATE) for k in range(2)]
