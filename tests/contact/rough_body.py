"""A rigid body with a hole on a fixed pin and Coulomb's friction, from event to event.

Everything is in absolute coordinates (x, y, θ) of the centre of mass, with the force at the point
of contact; impacts go from piece to piece of the path of impulses by Coulomb's law alone.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

CLOSING = 1e-3
"""Rate in m/s below which an impact closes the contact, as is usual."""


@dataclass
class RoughBody:
    """Lengths in m, mass in kg, inertia about the centre of mass in kg m²."""

    mass: float
    inertia: float
    arm: float  # from the hole to the centre of mass, along the body
    pin: float
    size: float
    friction: float
    restitution: float
    poisson: bool = False
    gravity: float = 0.0

    def touching(self, y):
        """Distance of the centres, the two directions, levers from the centre, rates (d', slip)."""
        angle, (vx, vy, spin) = y[2], y[3:]
        arm = -self.arm * np.array([np.cos(angle), np.sin(angle)])
        hole = y[:2] + arm
        distance = np.hypot(*hole)
        axes = np.array([hole, [-hole[1], hole[0]]]) / distance
        lever = arm - (self.pin + distance) * axes[0]
        moving = np.array([vx, vy]) + spin * np.array([-lever[1], lever[0]])
        return distance, axes, arm, lever, axes @ moving

    def pushed(self, y, along):
        """What a force or impulse at the contact, with parts along `axes`, does to rates."""
        _, axes, _, lever, _ = self.touching(y)
        acting = along @ axes
        turning = (lever[0] * acting[1] - lever[1] * acting[0]) / self.inertia
        return np.array([*(acting / self.mass), turning])

    def mobility(self, y):
        """Changes of (d', slip) by unit impulses along both directions, shape (2, 2)."""
        _, axes, _, lever, _ = self.touching(y)
        turn = axes @ np.array([-lever[1], lever[0]])
        return np.eye(2) / self.mass + np.outer(turn, turn) / self.inertia

    def friction_ratio(self, mobility, slip):
        """Impulse along the wall over the normal one, by Coulomb's law."""
        if slip != 0.0:
            return -self.friction * np.sign(slip)
        hold = mobility[1, 0] / mobility[1, 1]
        return hold if abs(hold) <= self.friction else self.friction * np.sign(hold)

    def impact(self, y):
        """State behind an impact, and what happened in it."""
        impulse, seen, _ = self._bounce(y)
        return self._behind(y, impulse), seen

    def rubbed(self, y):
        """Energy that friction takes in an impact."""
        return self._bounce(y)[2]

    def _bounce(self, y):
        """Impulse, what happened, and −∫ slip d(impulse along the wall)."""
        mobility = self.mobility(y)
        start = self.touching(y)[4]
        energy = start @ np.linalg.solve(mobility, start)

        def bounced(rebound):
            return self._path(mobility, start, lambda rates, _: -rates[0] - rebound)

        def gained(rebound):
            rates = bounced(rebound)[0]
            return rates @ np.linalg.solve(mobility, rates) - energy

        wanted = self.restitution * start[0]
        if self.poisson:
            whole = (1 + self.restitution) * -bounced(0.0)[1][0]
            rates, impulse, seen, lost = self._path(
                mobility, start, lambda _, normal: normal - whole
            )
        elif gained(wanted) > 1e-12 * energy:
            most = brentq(gained, 0.0, wanted, xtol=1e-15, rtol=1e-14)
            rates, impulse, seen, lost = bounced(most)
            seen.add("limited")
        else:
            rates, impulse, seen, lost = bounced(wanted)
        if -rates[0] < CLOSING:
            _, impulse, seen, lost = bounced(0.0)
            seen.add("closed")
        return impulse, seen, lost

    def _path(self, mobility, start, beyond):
        """Rates, impulse, pieces and loss of the path until `beyond`, linear on each, is zero."""
        rates, impulse, seen, lost = start.copy(), np.zeros(2), set(), 0.0
        for _ in range(4):
            ratio = self.friction_ratio(mobility, rates[1])
            ahead = np.array([-1.0, ratio])
            change = mobility @ ahead
            if change[0] > 0.0:
                seen.add("jammed")
            here = beyond(rates, -impulse[0])
            slope = beyond(rates + change, 1.0 - impulse[0]) - here
            stop = -here / slope if slope > 0.0 else np.inf
            still = -rates[1] / change[1] if rates[1] * change[1] < 0.0 else np.inf
            seen.add("hold" if abs(ratio) < self.friction else "slip")
            if stop <= still:
                lost -= ratio * stop * (rates[1] + 0.5 * stop * change[1])
                return rates + stop * change, impulse + stop * ahead, seen, lost
            lost -= ratio * still * 0.5 * rates[1]
            rates, impulse = rates + still * change, impulse + still * ahead
            rates[1] = 0.0
            seen.add("stopped")
        raise AssertionError

    def _behind(self, y, impulse):
        return np.array([*y[:3], *(y[3:] + self.pushed(y, impulse))])

    def accelerated(self, y, force):
        """Accelerations, and those of indentation and slip, under a force at the contact."""
        distance, axes, arm, _, (rate, _) = self.touching(y)
        spin = y[5]
        found = self.pushed(y, force) - np.array([0.0, self.gravity, 0.0])
        hole = found[:2] + found[2] * np.array([-arm[1], arm[0]]) - spin**2 * arm
        moved = y[3:5] + spin * np.array([-arm[1], arm[0]])
        across = (moved @ axes[1]) / distance
        slipping = hole @ axes[1] - across * rate
        slipping -= found[2] * (self.pin + distance) + spin * rate
        return found, np.array([hole @ axes[0] + across * (moved @ axes[1]), slipping])

    def contact_force(self, y, sense):
        """Force that keeps d' at 0 while it slips in a sense, or holds (0): (−λ, f)."""
        none = self.accelerated(y, np.zeros(2))[1]
        if sense == 0:
            return np.linalg.solve(self.mobility(y), -none)
        acting = np.array([-1.0, -sense * self.friction])
        return acting * (none[0] / -(self.mobility(y) @ acting)[0])

    def sense(self, y):
        """How it goes on from a slip of 0."""
        normal, along = self.contact_force(y, 0)
        return 0 if abs(along) <= self.friction * -normal else int(-np.sign(along))

    def motion(self, y, times):
        """States at times, from flight, and the names and times of what happened."""
        y, t, mode, found, log = np.array(y, dtype=float), 0.0, "free", [], []
        for end in times:
            while t < end:

                def rates(_, y, mode=mode):
                    force = np.zeros(2) if mode == "free" else self.contact_force(y, mode)
                    return np.array([*y[3:], *self.accelerated(y, force)[0]])

                def gone(_, y, mode=mode):
                    if mode == "free":
                        return self.touching(y)[0] - self.size
                    if mode:
                        return -mode * self.touching(y)[4][1]
                    normal, along = self.contact_force(y, 0)
                    return along**2 - (self.friction * normal) ** 2

                gone.terminal, gone.direction = True, 1
                leg = solve_ivp(
                    rates, (t, end), y, "DOP853", rtol=1e-12, atol=1e-15, events=gone,
                    max_step=1e-5 if mode == "free" else 1e-3,  # bounces are short
                )  # fmt: skip
                t, y = leg.t[-1], leg.y[:, -1]
                if leg.status != 1:
                    continue
                log.append((t, mode))
                if mode == "free":
                    y, seen = self.impact(y)
                    if "closed" in seen:
                        slip = self.touching(y)[4][1]
                        mode = int(np.sign(slip)) if abs(slip) > 1e-13 else self.sense(y)
                elif mode:
                    mode = self.sense(y)
                else:
                    mode = int(-np.sign(self.contact_force(y, 0)[1]))
            found.append(y)
        return np.array(found), log
