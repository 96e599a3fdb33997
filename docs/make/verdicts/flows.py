"""Flows whose motion is known."""

from __future__ import annotations

import math

from scipy.integrate import solve_ivp

from make.verdicts.known import Known, of_flow
from make.verdicts.own_systems import Ode

SPARROW = "C. Sparrow, The Lorenz Equations (1982)"
HOLMES = "D. W. Jordan, P. Smith, Nonlinear Ordinary Differential Equations, 4th ed. (2007)"
ROESSLER = "O. E. Rössler, Phys. Lett. A 57 (1976) 397; cascade as in Wikipedia, Rössler attractor"


def crossing(entry: int, level: float, direction: int):
    """Points where an entry of the state crosses a level, by events of SciPy."""

    def section(start: Ode, count: int, period: float, rtol: float):
        def event(_, y):
            return y[entry] - level

        event.direction = direction
        event.terminal = count
        found = solve_ivp(
            start._function, (start.time, start.time + 2 * count * period), start.state,
            "DOP853", events=[event], rtol=max(rtol, 1e-12), atol=rtol,
        )  # fmt: skip
        points = found.y_events[0]
        return points.reshape(-1, len(start.state)), found.t_events[0]

    return section


def duffing(force: float, rtol: float) -> Ode:
    """x'' + 0.3 x' - x + x³ = force · cos 1.2 t."""

    def rates(time, y):
        x, v = y.tolist()
        return v, force * math.cos(1.2 * time) - 0.3 * v + x - x**3

    def jacobian(_, y):
        return (0.0, 1.0), (1 - 3 * y.item(0) ** 2, -0.3)

    return Ode(rates, jacobian, [1.0, 0.0], rtol, rtol)


def oscillator(damping: float, frequency: float, rtol: float) -> Ode:
    """x'' + damping x' + x = cos(frequency t)."""
    return Ode(
        lambda t, y: (y[1], math.cos(frequency * t) - damping * y[1] - y[0]),
        lambda _t, _y: ((0.0, 1.0), (-1.0, -damping)),
        [1.0, 0.0],
        rtol,
        rtol,
    )


def van_der_pol(mu: float, force: float, frequency: float, rtol: float) -> Ode:
    def rates(time, y):
        x, v = y.tolist()
        return v, mu * (1 - x * x) * v - x + force * math.cos(frequency * time)

    def jacobian(_, y):
        x, v = y.tolist()
        return (0.0, 1.0), (-2 * mu * x * v - 1, mu * (1 - x * x))

    return Ode(rates, jacobian, [1.0, 0.5], rtol, rtol)


def lorenz(r: float, rtol: float) -> Ode:
    def rates(_, y):
        a, b, c = y.tolist()
        return 10 * (b - a), r * a - b - a * c, a * b - 8 / 3 * c

    def jacobian(_, y):
        a, b, c = y.tolist()
        return (-10.0, 10.0, 0.0), (r - c, -1.0, -a), (b, a, -8 / 3)

    return Ode(rates, jacobian, [1.0, 1.0, r - 5.0], rtol, rtol)


def roessler(c: float, rtol: float) -> Ode:
    def rates(_, y):
        x, v, z = y.tolist()
        return -v - z, x + 0.1 * v, 0.1 + z * (x - c)

    def jacobian(_, y):
        x, _v, z = y.tolist()
        return (0.0, -1.0, -1.0), (1.0, 0.1, 0.0), (z, 0.0, x - c)

    # the third direction contracts by e⁻¹⁰⁰ in a period
    return Ode(rates, jacobian, [-1.0, -6.0, 0.1], rtol, rtol, parts=8)


def henon_heiles(y: float, along: float, rtol: float) -> Ode:
    def rates(_, state):
        a, b, u, v = state.tolist()
        return u, v, -a - 2 * a * b, -b - a * a + b * b

    def jacobian(_, state):
        a, b, _u, _v = state.tolist()
        return (
            (0.0, 0.0, 1.0, 0.0),
            (0.0, 0.0, 0.0, 1.0),
            (-1 - 2 * b, -2 * a, 0.0, 0.0),
            (-2 * a, -1 + 2 * b, 0.0, 0.0),
        )

    return Ode(rates, jacobian, [0.0, y, along, 0.0], rtol, 1e-3 * rtol)


def _forced() -> list[Known]:
    averaged = "averaging; J. Guckenheimer, P. Holmes, Nonlinear Oscillations (1983), 2.1"
    parlitz = "U. Parlitz, W. Lauterborn, Phys. Rev. A 36 (1987) 1428"
    found = [
        (f"Duffing, force {force:g}", verdict, period, HOLMES,
         lambda rtol, force=force: duffing(force, rtol), 1.2, True)
        for force, verdict, period in (
            (0.2, "periodic", 1), (0.28, "periodic", 2), (0.29, "periodic", 4),
            (0.37, "periodic", 5), (0.5, "chaotic", None), (0.65, "periodic", 2),
        )
    ]  # fmt: skip
    found += [
        ("Linear oscillator, damped, driven", "periodic", 1, "closed form",
         lambda rtol: oscillator(0.1, 1.3, rtol), 1.3, True),
        ("Linear oscillator, driven at √2 of its frequency", "quasi-periodic", None, "closed form",
         lambda rtol: oscillator(0.0, math.sqrt(2), rtol), math.sqrt(2), False),
        ("Van der Pol, μ = 0.2, driven off resonance", "quasi-periodic", None, averaged,
         lambda rtol: van_der_pol(0.2, 0.1, 1.3, rtol), 1.3, True),
        ("Van der Pol, μ = 0.2, driven at resonance", "periodic", 1, averaged,
         lambda rtol: van_der_pol(0.2, 0.4, 1.02, rtol), 1.02, True),
        ("Van der Pol, μ = 5, force 5, ω = 2.466", "chaotic", None, parlitz,
         lambda rtol: van_der_pol(5.0, 5.0, 2.466, rtol), 2.466, True),
    ]  # fmt: skip
    return [
        Known(name, verdict, period, source,
              of_flow(system, 2 * math.pi / frequency, dissipative=dissipative), dissipative)
        for name, verdict, period, source, system, frequency, dissipative in found
    ]  # fmt: skip


def _free() -> list[Known]:
    skokos = "Ch. Skokos, J. Phys. A 34 (2001) 10029"
    rising = crossing(0, 0.0, 1)
    found = [
        ("Van der Pol, μ = 1, free", "periodic", 1, "Liénard's theorem",
         lambda rtol: van_der_pol(1.0, 0.0, 1.0, rtol), 6.66, rising, True),
        ("Lorenz, r = 10", "at rest", None, SPARROW, lambda rtol: lorenz(10, rtol), 0.7,
         crossing(2, 9.0, 1), True),
        ("Lorenz, r = 28", "chaotic", None, SPARROW, lambda rtol: lorenz(28, rtol), 0.75,
         crossing(2, 27.0, 1), True),
        ("Lorenz, r = 160", "periodic", None, SPARROW, lambda rtol: lorenz(160, rtol), 0.29,
         crossing(2, 159.0, 1), True),
        ("Lorenz, r = 350", "periodic", None, SPARROW, lambda rtol: lorenz(350, rtol), 0.19,
         crossing(2, 349.0, 1), True),
        *[
            (f"Rössler, a = b = 0.1, c = {c:g}", verdict, period, ROESSLER,
             lambda rtol, c=c: roessler(c, rtol), 6.1, crossing(1, 0.0, -1), True)
            for c, verdict, period in (
                (4, "periodic", 1), (6, "periodic", 2), (8.5, "periodic", 4), (9, "chaotic", None),
                (12, "periodic", 3), (18, "chaotic", None),
            )
        ],
        ("Hénon–Heiles, E = 1/8, y = 0.55", "quasi-periodic", None, skokos,
         lambda rtol: henon_heiles(0.55, 0.2417, rtol), 6.3, rising, False),
        ("Hénon–Heiles, E = 1/8, y = −0.016", "chaotic", None, skokos,
         lambda rtol: henon_heiles(-0.016, 0.49974, rtol), 6.6, rising, False),
    ]  # fmt: skip
    return [
        Known(name, verdict, period, source,
              of_flow(system, time, section, dissipative=dissipative), dissipative)
        for name, verdict, period, source, system, time, section, dissipative in found
    ]  # fmt: skip


FLOWS = [*_forced(), *_free()]
