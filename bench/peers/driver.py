"""SciPy's solvers from exchange to exchange, through a whole scene.

`solve_ivp`, the usual way, finds the end of a roller by a terminal event. `odeint` is leaner but knows no events: it goes
most of the way by the time that the rates of the moment tell, and the rest with the spin angle of the wheel as the
independent variable, which ends at the end of the roller exactly (Henon, Physica D 5 (1982) 412).
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from common import March
from peers.equations import SPIN, ahead, bound, exchange, held, jacobian, motion, numpy_form, rates, scalar_form
from scipy.integrate import odeint, solve_ivp

from omnisim.stepper import march as go_on

NEAR = 0.15  # rad: from here on by the angle
MOST_OF_THE_WAY = 0.9  # in one go by the rates of the moment, so that a wheel that speeds up stays on its roller
SLOWEST = 3.0  # rad/s: a slower wheel, one that starts, goes no farther at a time than one of this rate
TOUCHING = 1e-9  # rad: beyond the end of its roller a wheel is no farther when another one leaves its own
MOST_STEPS = 10**7  # of LSODA between two outputs
IMPLICIT = ("LSODA", "Radau", "BDF")  # methods that want a Jacobian


class Equations(NamedTuple):
    """Functions of t and y: y', its Jacobian (None: SciPy takes differences), angles ahead of the wheels (W,), rad."""

    f: Callable
    jacobian: Callable | None
    ahead: Callable


def integrate(march: March, solver: str, form: str, tolerance: float) -> np.ndarray:
    """y at the end of the scene of a fresh march, by one of SOLVERS on one of FORMS; tolerance: relative and absolute.

    No wheel may lift off, rest on two rollers or reach the limit of its drive, and friction must be smooth.
    """
    run = march.run
    run.clock.goal = 0
    go_on(*march)  # finds the rollers in contact
    box, y, t = held(march), run.y[motion(march)], 0.0
    angles, change = bound(ahead, box, len(run.mode)), bound(exchange, box, len(y))
    for piece, end in enumerate([*march.parameters.starts[1:].tolist(), march.steps * float(run.clock.dt)]):
        run.clock.piece = piece
        left = True
        while left:
            t, y, left = SOLVERS[solver](Equations(*FORMS[form](march, box, len(y)), angles), t, y, end, tolerance)
            if left:
                y = change(t, y)
    return y


def by_solve_ivp(method: str, equations: Equations, t: float, y: np.ndarray, end: float, tolerance: float):
    """Up to the end of a roller or to time `end`: t, y, whether a roller is left."""

    def remaining(t, y):
        return equations.ahead(t, y).min()

    remaining.terminal = True
    options = {"jac": equations.jacobian} if method in IMPLICIT else {}
    found = solve_ivp(equations.f, (t, end), y, method, rtol=tolerance, atol=tolerance, events=remaining, **options)
    if found.status < 0:
        raise RuntimeError(f"{method}: {found.message}")
    return found.t[-1], found.y[:, -1], found.status == 1


def by_odeint(equations: Equations, t: float, y: np.ndarray, end: float, tolerance: float):
    """The same by LSODA without events."""
    settings = {"rtol": tolerance, "atol": tolerance, "tfirst": True, "mxstep": MOST_STEPS}
    angles = equations.ahead(t, y)
    wheels = len(angles)
    while True:
        spin_rates = np.abs(y[SPIN + wheels + 3 :][:wheels])
        times = angles / np.maximum(spin_rates, SLOWEST)
        soonest = times.argmin()
        if angles[soonest] < NEAR:
            break
        until = min(t + MOST_OF_THE_WAY * times[soonest], end)
        t, y = until, odeint(equations.f, y, (t, until), Dfun=equations.jacobian, **settings)[1]
        if t == end:
            return t, y, False
        angles = equations.ahead(t, y)
    for w in times.argsort():
        sense = np.copysign(1.0, y[SPIN + wheels + 3 + w])

        place = SPIN + w

        def by_angle(_, z, place=place):
            slopes = np.empty(len(z))
            slopes[:-1], slopes[-1] = equations.f(z[-1], z[:-1]), 1.0
            return slopes / slopes[place]

        stretch = y[place], y[place] + sense * angles[w]
        landed = odeint(by_angle, [*y, t], stretch, **settings)[1]
        if equations.ahead(landed[-1], landed[:-1]).min() > -TOUCHING:
            break
    if landed[-1] > end:
        return end, odeint(equations.f, y, (t, end), Dfun=equations.jacobian, **settings)[1], False
    return landed[-1], landed[:-1], True


SOLVERS = {f"{method}, solve_ivp": partial(by_solve_ivp, method) for method in ("LSODA", "Radau", "BDF", "DOP853")}
SOLVERS["LSODA, odeint"] = by_odeint
FORMS = {
    "NumPy": lambda march, box, n: (numpy_form(march), None),
    "scalars": lambda march, box, n: (scalar_form(march), None),
    "compiled": lambda march, box, n: (bound(rates, box, n), bound(jacobian, box, n, n)),
}
