"""SciPy's solvers from exchange to exchange, through a whole scene."""

import time
import warnings
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.integrate import ODEintWarning, odeint, solve_ivp

from bench.common import March
from bench.peers.equations import (
    SPIN,
    SPIN_RATE,
    ahead,
    bound,
    exchange,
    held,
    jacobian,
    motion,
    numpy_form,
    numpy_machine,
    rates,
    scalar_form,
)
from omnisim.march.march import march as go_on

NEAR = 0.15  # rad: from here to the end of its roller a wheel goes by the angle
MOST_OF_THE_WAY = 0.9  # in one go by the rate of the moment, so that a wheel that speeds up stays on its roller
MOST_STEPS = 50_000  # of odeint in one go
IMPLICIT = ("LSODA", "Radau", "BDF")  # methods that want a Jacobian

warnings.simplefilter("ignore", ODEintWarning)  # Stalled tells it


class Stalled(RuntimeError):
    """A solver that fails or makes no headway any more."""


class Equations(NamedTuple):
    """Functions of t and y: y', its Jacobian (None: SciPy takes differences), angles ahead of the wheels (W,), rad."""

    f: Callable
    jacobian: Callable | None
    ahead: Callable


def integrate(march: March, solver: str, form: str, tolerance: float, patience: float = 60.0) -> np.ndarray:
    """y at the end of the scene of a fresh march, by one of SOLVERS on one of FORMS; tolerance: relative and absolute.

    No wheel may lift off, rest on two rollers or reach the limit of its drive, and friction must be smooth; `odeint`
    is for bare wheels. Stalled after `patience` seconds, looked at after every step or piece of the way.
    """
    run, deadline = march.run, time.perf_counter() + patience
    run.clock.goal = 0
    go_on(*march)  # finds the rollers in contact
    box, y, t = held(march), run.y[motion(march)], 0.0
    angles, change = bound(ahead, box, len(run.mode)), bound(exchange, box, len(y))
    end_of_all = march.steps * float(run.clock.dt)
    knots = [knot for knot in march.parameters.starts[1:].tolist() if knot < end_of_all]
    for piece, end in enumerate([*knots, end_of_all]):
        run.clock.piece = piece
        left = True
        while left:
            equations = Equations(*FORMS[form](march, box, len(y)), angles)
            t, y, left = SOLVERS[solver](equations, t, y, end, tolerance, deadline)
            if left:
                y = change(t, y)
    return y


def by_solve_ivp(method: str, equations: Equations, t: float, y: np.ndarray, end: float, tolerance: float, deadline):
    """Up to the end of a roller, a terminal event, or to time `end`: t, y, whether a roller is left."""

    def remaining(t, y):
        if time.perf_counter() > deadline:
            raise Stalled(method)
        return equations.ahead(t, y).min()

    remaining.terminal = True
    options = {"jac": equations.jacobian} if method in IMPLICIT else {}
    found = solve_ivp(equations.f, (t, end), y, method, rtol=tolerance, atol=tolerance, events=remaining, **options)
    if found.status < 0:
        raise Stalled(f"{method}: {found.message}")
    return found.t[-1], found.y[:, -1], found.status == 1


def by_odeint(equations: Equations, t: float, y: np.ndarray, end: float, tolerance: float, deadline):
    """The same for a bare wheel by LSODA without events, which are foreign to `odeint`.

    Most of the way by the rate of the moment, the rest with the spin angle as the independent variable, which ends at
    the end of the roller exactly (Henon, Physica D 5 (1982) 412).
    """

    def go(f, start, y, stop, jacobian=None):
        settings = {"rtol": tolerance, "atol": tolerance, "mxstep": MOST_STEPS, "tfirst": True, "full_output": True}
        found, account = odeint(f, y, (start, stop), Dfun=jacobian, **settings)
        if account["message"] != "Integration successful." or time.perf_counter() > deadline:
            raise Stalled(f"odeint: {account['message']}")
        return found[1]

    def by_angle(_, z):
        slopes = np.empty(len(z))
        slopes[:-1], slopes[-1] = equations.f(z[-1], z[:-1]), 1.0
        return slopes / slopes[SPIN]

    while (angle := equations.ahead(t, y)[0]) > NEAR:
        until = min(t + MOST_OF_THE_WAY * angle / abs(y[SPIN_RATE]), end)
        t, y = until, go(equations.f, t, y, until, equations.jacobian)
        if t == end:
            return t, y, False
    exit_angle = y[SPIN] + np.copysign(angle, y[SPIN_RATE])
    *landed, at = go(by_angle, y[SPIN], [*y, t], exit_angle)
    landed[SPIN] = exit_angle  # an implicit step leaves it off by some of the tolerance
    if at > end:
        return end, go(equations.f, t, y, end, equations.jacobian), False
    return at, np.array(landed), True


SOLVERS = {f"{method}, solve_ivp": partial(by_solve_ivp, method) for method in ("LSODA", "Radau", "BDF", "DOP853")}
SOLVERS["LSODA, odeint"] = by_odeint
FORMS = {
    "NumPy": lambda march, box, n: ((numpy_form if len(march.run.mode) == 1 else numpy_machine)(march), None),
    "scalars": lambda march, box, n: (scalar_form(march), None),
    "compiled": lambda march, box, n: (bound(rates, box, n), bound(jacobian, box, n, n)),
}
