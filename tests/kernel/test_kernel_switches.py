"""Modes in the graph: shared, named, in a fixed order, and nothing where there are none."""

import numpy as np
import pytest

import linkages
from linkages.kernel.model import Model
from linkages.kernel.system import System
from linkages.solution.plan import Plan, kernel_source


def collecting(model):
    """As long as accelerations are built, what is asked for becomes a mode."""
    return model.switches.collecting()


@pytest.fixture
def model():
    return Model(System(linkages.load("pendulum")).topology)


def test_equal_functions_have_one_mode(model):
    speed, angle = model.inputs.rate(0), model.inputs.coordinate(0)
    with collecting(model):
        one = model.switches.add("speed", speed)
        assert model.switches.add("the same", 1.0 * speed) is one
        # the opposite function has the opposite mode
        opposite = model.switches.add("against", -speed)
        assert opposite.operation == "neg"
        assert opposite.operands == (one,)
        # where another mode decides whether it is watched, it is another switch
        inner = model.switches.add("speed", speed, active=model.switches.add("angle", angle))
    assert inner is not one
    assert model.switches.names == ("mode speed", "mode angle", "mode speed (2)")
    assert [switch.active for switch in model.switches.switches] == [None, None, 1]


def test_memories_belong_to_switches(model):
    speed, angle = model.inputs.rate(0), model.inputs.coordinate(0)
    with collecting(model):
        model.switches.add("touch", angle)
        first = model.switches.memory("touch", speed)
        assert model.switches.memory("touch", speed) is first
        assert model.switches.memory("touch", speed * speed) is not first
    assert model.switches.names[1:] == ("memory touch", "memory touch (2)")


def test_what_no_acceleration_needs_is_no_mode(model):
    graph, speed = model.graph, model.inputs.rate(0)
    assert model.switches.add("late", speed) is graph.select(speed, graph.one, -graph.one)
    with collecting(model):
        number = model.switches.add("number", model.gravity.y + 9.0)
    assert not model.switches.switches
    assert number.operation != "input"
    with pytest.raises(ValueError, match="'wall' jumps, but no acceleration needs it"):
        model.switches.add("wall", speed, jump=[-speed])


def test_active_must_be_a_mode(model):
    with collecting(model), pytest.raises(ValueError, match="must be the mode of a switch"):
        model.switches.add("speed", model.inputs.rate(0), active=model.inputs.rate(0))


def test_rates_along_the_motion(model):
    """g = t·ω² has the rate ω² + 2 t ω α."""
    t, speed = model.inputs.time, model.inputs.rate(0)
    (rate,) = model.switches.rates([t * speed * speed], model.free_accelerations)
    values = model.evaluator([rate, *model.free_accelerations])(
        t=np.array([0.3]),
        y=np.array([0.4, 2.0]),
        a=np.zeros(1),
        p=np.ones(len(model.inputs.parameters)),
    )
    assert values[0] == pytest.approx(4.0 + 2 * 0.3 * 2.0 * values[1])


def test_nothing_without_switches():
    """Nine bars: no functions, no room for modes, no words about them."""
    system = System(linkages.load("ninebar"))
    source = kernel_source(system.topology)
    assert source.switched == ()
    assert source.program.held == 0
    assert "modes" not in source.program.text
    plan = Plan.of(system)
    assert plan.switching is None
    assert plan.bind(system).held == 0
