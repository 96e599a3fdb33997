"""Kernels written by hand, with motions known in closed form, for the tests of the solvers."""

# Kernels share two signatures, and few need every argument.
# ruff: noqa: ARG001

from __future__ import annotations

import math

import numpy as np
from scipy.special import ellipj, ellipk

from linkages.kernel.code.elementary_functions import elementary
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import (
    Int,
    Real,
    floats,
    select,
    select_of,
    sqrt,
)
from linkages.kernel.code.procedure import Procedure, text_of, traced
from linkages.solvers import Flow, Kernel

SIZE = 20  # of a chain: so many coordinates that generated steps go through them in a loop


class TracedCode:
    """A function that writes itself, as machine code; it returns a status, 0 where it has none."""

    def __init__(self, function, body):
        body.__name__ = function.__name__
        self._code = MachineCode(text_of(traced(body)))
        self.address = self._code.address(function.__name__)


def clock(function):
    def body(code: Procedure, t: Real, parameters: Int, timed: Int) -> Int:
        return function(t, floats(parameters), floats(timed)) or code.value(0)

    return TracedCode(function, body)


def rates(function):
    def body(code: Procedure, state: Int, parameters: Int, timed: Int, out: Int) -> Int:
        given = map(floats, (state, parameters, timed, out))
        return function(*given) or code.value(0)

    return TracedCode(function, body)


def sin(x):
    return elementary("sin", x)


def cos(x):
    return elementary("cos", x)


def cube_of(square):
    """The third power of a root."""
    return square * sqrt(square)


@clock
def no_clock(t, p, timed):
    """Nothing depends on time alone."""


@clock
def logging_clock(t, p, timed):
    """Writes every time that it is asked for behind p1, which counts them."""
    p[1] += 1.0
    p[p[1].to_int + 1] = t


@rates
def harmonic_rates(y, p, timed, out):
    out[0] = -p[0] * y[0]


@rates
def uniform_rates(y, p, timed, out):
    """A constant acceleration."""
    out[0] = p[0]


@rates
def pendulum_rates(y, p, timed, out):
    out[0] = -p[0] * sin(y[0])


@clock
def drive_clock(t, p, timed):
    timed[0] = p[1] * cos(p[2] * t)
    p[3] += 1.0


@rates
def driven_rates(y, p, timed, out):
    out[0] = -p[0] * y[0] + timed[0]


@rates
def coupled_rates(y, p, timed, out):
    out[0] = -p[0] * y[0] - p[1] * (y[0] - y[1])
    out[1] = -p[0] * y[1] - p[1] * (y[1] - y[0])


@rates
def passing_rates(y, p, timed, out):
    """Uniform motion past q = 1, with the margin sqrt((q - 1)² + p0²)."""
    distance = y[0] - 1.0
    out[0] = 0.0
    out[1] = sqrt(distance * distance + p[0] * p[0])
    out[2] = select(out[1] > 0.0, distance * y[1] / out[1], 0.0)


@rates
def limited_rates(y, p, timed, out):
    """Uniform motion of which the second block reaches as far as q = p0."""
    out[0] = 0.0
    return select_of(Int, y[0] > p[0], 2, 0)


@clock
def limited_clock(t, p, timed):
    """A driven block that reaches as far as t = p0."""
    return select_of(Int, t > p[0], 1, 0)


@rates
def free_rates(y, p, timed, out):
    out[0] = 0.0


@rates
def decay_rates(y, p, timed, out):
    out[0] = -p[0] * y[1]


@rates
def damped_slopes(y, p, timed, out):
    """Derivatives of -p0 (v + sin q)."""
    p[1] += 1.0
    out[0] = -p[0] * cos(y[0])
    out[1] = -p[0]


@rates
def damped_rates(y, p, timed, out):
    """Stiff for large p0: the speed follows -sin q within a time of 1/p0."""
    out[0] = -p[0] * (y[1] + sin(y[0]))


@rates
def arenstorf_rates(y, p, timed, out):
    """The restricted three-body problem (Hairer, Nørsett & Wanner, II.0)."""
    mass = p[0]
    near, far = y[0] + mass, y[0] - (1.0 - mass)
    first = (1.0 - mass) / cube_of(near * near + y[1] * y[1])
    second = mass / cube_of(far * far + y[1] * y[1])
    out[0] = y[0] + 2.0 * y[3] - first * near - second * far
    out[1] = y[1] - 2.0 * y[2] - (first + second) * y[1]


@rates
def chain_rates(y, p, timed, out):
    """Pendulums in a row, each pulled by both neighbours."""
    for i in range(SIZE):
        before = y[i - 1] if i else 0.0
        after = y[i + 1] if i < SIZE - 1 else 0.0
        out[i] = -sin(y[i]) + 0.5 * (before + after - 2.0 * y[i])


@rates
def explosion_rates(y, p, timed, out):
    """Blow-up in finite time: v = v0 / (1 - v0 t)."""
    out[0] = y[1] * y[1]


@clock
def line_clock(t, p, timed):
    """A level that rises with time."""
    timed[0] = p[3] * t


@rates
def line_function(y, p, timed, out):
    """p0 q + p1 v + p2 sin q - p3 t, and its rate from the acceleration behind q and v."""
    p[4] += 1.0
    out[0] = p[0] * y[0] + p[1] * y[1] + p[2] * sin(y[0]) - timed[0]
    out[1] = p[0] * y[1] + p[1] * y[2] + p[2] * cos(y[0]) * y[1] - p[3]


@rates
def nothing_rates(y, p, timed, out):
    """Nothing moves."""


def line(*parameters):
    """A function for events: see `line_function`."""
    return Kernel(
        clock=line_clock.address,
        rates=line_function.address,
        parameters=np.array([*parameters, 0.0]),
        timed_size=1,
    )


def flow(rates, parameters=(), *, clock=no_clock, rotates=(False,), blocks=0, timed=0):
    return Flow(
        clock=clock.address,
        rates=rates.address,
        parameters=np.array(parameters, dtype=float),
        timed_size=timed,
        coordinates=len(rotates),
        rotates=np.array(rotates, dtype=bool),
        margin_scale=np.ones(blocks),
        keepalive=(clock, rates),
    )


def pendulum():
    """A pendulum with unit natural frequency."""
    return flow(pendulum_rates, [1.0], rotates=[True])


def harmonic():
    """An oscillator with a frequency of 2 rad/s."""
    return flow(harmonic_rates, [4.0])


def arenstorf():
    """Equations of a periodic orbit past earth and moon."""
    return flow(arenstorf_rates, [0.012277471], rotates=[False, False])


ORBIT = [0.994, 0.0, 0.0, -2.00158510637908252240537862224]
PERIOD = 17.0652165601579625588917206249


def swing(amplitude, times):
    """Angle and speed of a pendulum released at rest, by elliptic functions."""
    k = math.sin(amplitude / 2)
    sn, cn, *_ = ellipj(np.asarray(times) + ellipk(k * k), k * k)
    return 2 * np.arcsin(k * sn), 2 * k * cn


def rotation(speed, times):
    """Angle of a pendulum that turns over, started hanging with a speed > 2."""
    *_, amplitude = ellipj(speed * np.asarray(times) / 2, (2 / speed) ** 2)
    return 2 * amplitude


def driven(stiffness=4.0, force=1.5, frequency=3.0):
    """A driven oscillator; its last parameter counts the calls of the clock."""
    return flow(
        driven_rates,
        [stiffness, force, frequency, 0.0],
        clock=drive_clock,
        rotates=[False],
        timed=1,
    )


def driven_motion(times, stiffness=4.0, force=1.5, frequency=3.0):
    """Displacement of the driven oscillator from rest at zero."""
    times = np.asarray(times)
    amplitude = force / (stiffness - frequency**2)
    return amplitude * (np.cos(frequency * times) - np.cos(math.sqrt(stiffness) * times))


def coupled():
    """Two oscillators of stiffness 1 with a coupling of stiffness 2."""
    return flow(coupled_rates, [1.0, 2.0], rotates=[False, False])


def coupled_motion(times):
    """Displacements of the coupled oscillators from (1, 0) at rest."""
    times = np.asarray(times)
    together, against = np.cos(times), np.cos(math.sqrt(5.0) * times)
    return np.stack([together + against, together - against], axis=-1) / 2
