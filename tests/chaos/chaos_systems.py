"""Systems with published values (J. C. Sprott, Chaos and Time-Series Analysis, Oxford 2003)."""

import math

import numpy as np
from make.verdicts.own_systems import Map, Ode
from scipy.integrate import solve_ivp

from linkages.chaos.lyapunov import run_exponents
from linkages.kernel.system import System
from linkages.options.analysis_options import ExponentOptions
from linkages.solution.run_options import options_of


def lorenz_rates(_, y):
    a, b, c = y.tolist()
    return (10 * (b - a), 28 * a - b - a * c, a * b - 8 / 3 * c)


def lorenz(rtol=1e-7):
    def jacobian(_, y):
        a, b, c = y.tolist()
        return ((-10.0, 10.0, 0.0), (28 - c, -1.0, -a), (b, a, -8 / 3))

    return Ode(lorenz_rates, jacobian, [1.0, 1.0, 20.0], rtol=rtol, atol=rtol)


def roessler_rates(_, y):
    a, b, c = y.tolist()
    return (-b - c, a + 0.2 * b, 0.2 + c * (a - 5.7))


def roessler(rtol=1e-7):
    def jacobian(_, y):
        a, _, c = y.tolist()
        return ((0.0, -1.0, -1.0), (1.0, 0.2, 0.0), (c, 0.0, a - 5.7))

    return Ode(roessler_rates, jacobian, [1.0, 1.0, 0.0], rtol=rtol, atol=rtol)


def henon():
    return Map(
        lambda x: (1 - 1.4 * x[0] ** 2 + x[1], 0.3 * x[0]),
        lambda x: ((-2.8 * x[0], 1.0), (0.3, 0.0)),
        [0.1, 0.1],
    )


def logistic(r, start=0.3):
    return Map(lambda x: r * x * (1 - x), lambda x: [[r * (1 - 2 * x[0])]], [start])


def sprott_pendulum(rtol=1e-7):
    """θ'' + θ'/4 + sin θ = 1.5 cos φ, φ' = 2/3, with state (θ, θ', φ)."""

    def rates(_, y):
        angle, speed, phase = y.tolist()
        return (speed, 1.5 * math.cos(phase) - math.sin(angle) - 0.25 * speed, 2 / 3)

    def jacobian(_, y):
        angle, _, phase = y.tolist()
        return ((0.0, 1.0, 0.0), (-math.cos(angle), -0.25, -1.5 * math.sin(phase)), (0.0, 0.0, 0.0))

    return Ode(rates, jacobian, [0.0, 0.0, 0.0], rtol, rtol, angles=[True, False, True])


def duffing(rtol=1e-7):
    """x'' + 0.2 x' - x + x³ = 0.3 cos t, with state (x, x') and time apart."""

    def rates(time, y):
        place, speed = y.tolist()
        return (speed, 0.3 * math.cos(time) - 0.2 * speed + place - place**3)

    def jacobian(_, y):
        return ((0.0, 1.0), (1 - 3 * y.item(0) ** 2, -0.2))

    return Ode(rates, jacobian, [0.1, 0.0], rtol, rtol)


def taylor_pendulum(strength, rtol=1e-8):
    """J. R. Taylor, Classical Mechanics, eq. (12.11): β = ω₀/4, ω₀ = 1.5 ω, ω = 2π."""
    drive = 2 * math.pi
    natural = 1.5 * drive

    def rates(time, y):
        angle, speed = y.tolist()
        force = strength * natural**2 * math.cos(drive * time)
        return (speed, force - 0.5 * natural * speed - natural**2 * math.sin(angle))

    def jacobian(_, y):
        return ((0.0, 1.0), (-(natural**2) * math.cos(y.item(0)), -0.5 * natural))

    return Ode(rates, jacobian, [-math.pi / 2, 0.0], rtol, rtol, angles=[True, False])


def henon_heiles(energy, y, speed=0.0, rtol=1e-9):
    """Hénon–Heiles on the section x = 0 (M. Hénon, C. Heiles, Astron. J. 69 (1964) 73)."""

    def rates(_, state):
        a, b, u, v = state.tolist()
        return (u, v, -a - 2 * a * b, -b - a * a + b * b)

    def jacobian(_, state):
        a, b, _, _ = state.tolist()
        return (
            (0.0, 0.0, 1.0, 0.0),
            (0.0, 0.0, 0.0, 1.0),
            (-1 - 2 * b, -2 * a, 0.0, 0.0),
            (-2 * a, -1 + 2 * b, 0.0, 0.0),
        )

    along = math.sqrt(2 * energy - speed**2 - y**2 + 2 / 3 * y**3)
    return Ode(rates, jacobian, [0.0, y, along, speed], rtol, 1e-3 * rtol)


def orbit(system, count, interval, skip=0):
    """States after each interval, shape (count, d)."""
    if skip:
        system.advance(skip * interval)
    states = []
    for _ in range(count):
        system.advance(interval)
        states.append(system.state)
    return np.array(states)


def samples(rates, start, interval, count, skip=100):
    """Equidistant samples of an attractor, shape (count, d): what a single run is quicker for.

    A loose tolerance is enough: sets of states are insensitive to it, unlike single motions.
    """
    times = interval * np.arange(skip, skip + count)
    span = (0.0, float(times[-1]))
    solution = solve_ivp(rates, span, start, "DOP853", times, rtol=1e-6, atol=1e-6)
    return solution.y.T


def exponents_of(mechanism, **options):
    """What `linkages.lyapunov` averages: exponents with the growth in every interval."""
    return run_exponents(System(mechanism), options_of(ExponentOptions, mechanism, options))
