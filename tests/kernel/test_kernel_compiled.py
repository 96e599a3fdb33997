"""Machine code against the evaluation of the same graph with NumPy."""

import ctypes
import platform

import numpy as np
import pytest
from kernel_motion import call
from linkage_models import program, system

from linkages.kernel.code import machine
from linkages.kernel.code.machine import ENVIRONMENT_VARIABLE, cache_folder
from linkages.kernel.code.program import Kernel, bind_kernel


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory):
    """A cache of these tests' own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path_factory.mktemp("cache") / "kernels"))
        cache_folder.cache_clear()
        yield
    cache_folder.cache_clear()


class Compiled:
    """The two functions of a kernel, called with arrays."""

    def __init__(self, of):
        self.of = of
        self.written = program(of)
        self.kernel = bind_kernel(self.written, of.parameters)
        self.size = len(of.topology.free) + 2 * len(of.topology.solved_blocks)

    def __call__(self, time, state):
        self.clock_status, self.rates_status, found = call(self.kernel, time, state, self.size)
        return found

    @property
    def roots(self):
        model = self.of.model
        return [*model.free_accelerations, *model.margins, *model.margin_rates]


@pytest.mark.parametrize("name", ["doublependulum", "clearance", "ninebar"])
def test_compiled_equals_evaluated(name):
    of = system(name)
    compiled = Compiled(of)
    random = np.random.default_rng(3)
    count = len(of.topology.free)
    scale = np.abs(of.evaluate(compiled.roots)[:, 0])
    for _ in range(20):
        time = random.uniform(0, 0.2)
        state = of.state + np.concatenate(
            [random.uniform(-0.2, 0.2, count), random.uniform(-5, 5, count)]
        )
        found = compiled(time, state)
        assert (compiled.clock_status, compiled.rates_status) == (0, 0)
        expected = of.evaluate(compiled.roots, time, state[:, None])[:, 0]
        scale = np.maximum(scale, np.abs(expected))
        # sums are contracted to fused multiply-adds: a few roundings of the largest terms
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-13 * scale.max())
        assert np.all(np.abs(found - expected) <= 2e-13 * scale)


def test_parameters_are_arguments():
    """The same machine code, other numbers."""
    one, other = (
        Compiled(system("clearance")),
        Compiled(system("clearance", **{"bars.crank.mass": 3})),
    )
    assert one.kernel.keepalive is other.kernel.keepalive
    found, expected = other(0, other.of.state), other.of.evaluate(other.roots)[:, 0]
    assert found == pytest.approx(expected, rel=1e-12)
    assert found != pytest.approx(one(0, one.of.state), rel=1e-3)
    # and the first one still has its own
    assert one(0, one.of.state) == pytest.approx(one.of.evaluate(one.roots)[:, 0], rel=1e-12)


def test_an_unreachable_block_of_the_state_is_numbered():
    """Clearance, then a free crank: the rocker pulled out of reach."""
    of = system("clearance", **{"bars.rocker.length": 0.4, "bars.crank.length": 0.4})
    compiled = Compiled(of)
    compiled(0, [np.pi, 0.4, 2, -0.3])
    assert (compiled.clock_status, compiled.rates_status) == (0, 1)
    compiled(0, of.state)
    assert compiled.rates_status == 0


def test_an_unreachable_block_of_the_time_is_reported_by_the_clock():
    of = system("fourbar", **{"bars.rocker.length": 0.35, "bars.crank.length": 0.35})
    compiled = Compiled(of)
    compiled(0.0, [])
    assert compiled.clock_status == 0
    compiled((np.pi - 1) / 2, [])  # the crank points away from the rocker
    assert compiled.clock_status == 1


def test_a_not_a_number_is_no_position():
    compiled = Compiled(system("ninebar"))
    compiled(0, [np.nan, 0.0])
    assert compiled.rates_status == 1


def test_the_second_block_has_its_own_number():
    of = system("stephenson", **{"bars.arm.length": 0.52})
    compiled = Compiled(of)
    statuses = set()
    for time in np.linspace(0, 2 * np.pi / 3, 40):
        compiled(time, [])
        statuses.add(compiled.clock_status)
        radicands = of.evaluate([r.radicand for r in of.model.reaches], time)[:, 0]
        lacking = np.flatnonzero(~(radicands >= 0))
        assert compiled.clock_status == (lacking[0] + 1 if lacking.size else 0)
    assert 1 not in statuses


@pytest.mark.skipif(
    platform.machine().lower() not in ("x86_64", "amd64"), reason="names a processor of this family"
)
def test_bits_do_not_depend_on_the_instruction_set(monkeypatch):
    """Also where the processor has no fused multiply-add, and the C library computes it."""
    of = system("ninebar")
    written, found = program(of), []
    for features in (machine._host(), (machine._host()[0], "x86-64", "")):
        monkeypatch.setattr(machine, "_host", lambda features=features: features)
        code = machine.MachineCode(written.assembly)
        values = np.zeros(sum(written.parameters))
        values[: written.parameters[0]] = of.parameters
        ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(code.address("prepare"))(
            values.ctypes.data
        )
        kernel = Kernel(
            clock=code.address("clock"), rates=code.address("rates"), parameters=values,
            timed_size=written.timed, keepalive=code,
        )  # fmt: skip
        random = np.random.default_rng(8)
        found.append(
            [
                call(kernel, random.uniform(0, 2), of.state + 0.01 * random.normal(size=2), 1)[2]
                for _ in range(100)
            ]
        )
    np.testing.assert_array_equal(*found)


def test_a_long_compilation_is_announced_once(monkeypatch, caplog):
    """Not where the result is known."""
    text = program(system("pendulum")).assembly + "\n; another text, which is not kept yet\n"
    monkeypatch.setattr(machine, "LONG_TEXT", machine._equivalent(text) - 1)
    for _ in range(2):
        machine.MachineCode(text)
    (said,) = caplog.messages
    assert "characters of equations, which can take minutes" in said
