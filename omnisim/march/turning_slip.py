"""How friction turns the slip of one contact into its final direction, and slows it down, while nothing else changes.

    v' = b - M A u        u = v / |v|,  M = mu N,  1 / M = m_0 + m . u

b is the slip acceleration without this friction, A the mobility of the contact. Loads are linear in the forces along
the floor, so 1 / N is linear in the direction of this one. With a time tau of its own,

    v_tau = c b - A v,    t_tau = c        c = |v| / M = m_0 |v| + m . v

which is linear but for c and b, that are less than what friction does: along the axes of A it falls exponentially, and
Runge-Kutta's method of order four takes the rest along (Lawson, SIAM J. Numer. Anal. 4 (1967) 372). A step is most of
the time in which it falls to 1 / e along the axis that gives way most, however fast v turns meanwhile; and before v has
turned at all, as far as it goes straight on.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Slip
from omnisim.contact.kinematics import slip_jacobian
from omnisim.contact.mobility import applied
from omnisim.contact.set_valued import STICK, TINY
from omnisim.dynamics.planar_body import (
    contact_mobility,
    free_equations,
    held_equations,
    inverse,
    set_contact,
    set_lever,
)
from omnisim.dynamics.twist import body_motion
from omnisim.dynamics.wheel import contact_state

STRAIGHT = 3e-4  # part of its slowing down that slip misses by its angle from its final direction: nearly straight
SAME = 0.99  # cosine of the angle up to which slip has not turned
STEP = 0.7  # of the time in which slip falls to 1 / e where it gives way most
LEFT = 1e-6  # part of slip that is none
BESIDE = 0.005  # part of slip, of which half the square is added to its size
MOST_STEPS = 50


def quadrature(step: float) -> np.ndarray:
    """Weights of the ends and the middle of a step for what falls by e^-step or e^-2step in it, or does not change: so
    the time that straight slip takes, and its way, come out exactly without b."""
    falls = np.exp(-0.5 * step * np.arange(3))
    means = [1.0, -math.expm1(-step) / step, -math.expm1(-2.0 * step) / (2.0 * step)]
    return np.linalg.solve(np.vander(falls, increasing=True).T, means)


FIRST, MIDDLE, LAST = quadrature(STEP)


class Friction(NamedTuple):
    """1 / (mu N) by the direction u of slip, m_0 + m_h u_h + m_k u_k, 1/N."""

    mean: float
    h: float
    k: float


class Turned(NamedTuple):
    """Slip that has nearly come to its final direction, or is gone: after a time, s, and from when on it has turned, s;
    slip then (h, k), m/s; the way that it has gone, m. The time is infinite if it never does."""

    gone: bool
    time: float
    straight: float
    h: float
    k: float
    way_h: float
    way_k: float


@kernel
def one_friction(limit):
    """The Friction that is the same in all directions, N."""
    return Friction(1.0 / limit, 0.0, 0.0)


@kernel
def two_frictions(v, limit, u, final):
    """The Friction that is `limit` along slip v and `final` along the unit vector u, N; of the directions between them
    nothing else is known."""
    size = 1.0 / math.sqrt(v.h * v.h + v.k * v.k)
    h, k = u.h - size * v.h, u.k - size * v.k
    by = (1.0 / final - 1.0 / limit) / max(h * h + k * k, TINY)
    return Friction(1.0 / final - by * (h * u.h + k * u.k), by * h, by * k)


@outlined
def turn_in(b, a, friction, v):
    """Follow slip v (Slip, m/s) until it is Turned, or gone; b in m/s^2, a in 1/kg."""
    x, y, p_rate, q_rate = axes_of(a)
    b_p, b_q = x * b.h + y * b.k, x * b.k - y * b.h
    m_0, m_p, m_q = friction.mean, x * friction.h + y * friction.k, x * friction.k - y * friction.h
    p, q = x * v.h + y * v.k, x * v.k - y * v.h
    first_p, first_q = p, q
    first = size_of(p, q)
    t, p, q, way_p, way_q = go_straight(p, q, (p_rate, q_rate), (b_p, b_q), (m_0, m_p, m_q))
    straight = t
    step = STEP / p_rate
    sixth = step / 6.0
    half_p, half_q = math.exp(-0.5 * STEP), math.exp(-0.5 * q_rate * step)
    full_p, full_q = half_p * half_p, half_q * half_q
    for _ in range(MOST_STEPS):
        speed = size_of(p, q)
        c_1 = m_0 * speed + m_p * p + m_q * q
        rate_p, rate_q = c_1 * b_p - p_rate * p, c_1 * b_q - q_rate * q
        along, turn = p * rate_p + q * rate_q, p * rate_q - q * rate_p
        drawn = p_rate * q * q + q_rate * p * p + along
        if p * first_p + q * first_q > SAME * speed * first:
            straight = t
        gone = speed < LEFT * first
        if gone and along < 0.0:
            t -= speed * speed * c_1 / along
        if gone or (drawn > 0.0 and turn * turn <= STRAIGHT * drawn * abs(along)):
            return Turned(gone, t, straight, x * p - y * q, x * q + y * p, x * way_p - y * way_q, x * way_q + y * way_p)
        g_p, g_q = step * b_p, step * b_q
        p_2, q_2 = half_p * (p + 0.5 * g_p * c_1), half_q * (q + 0.5 * g_q * c_1)
        c_2 = m_0 * size_of(p_2, q_2) + m_p * p_2 + m_q * q_2
        p_3, q_3 = half_p * p + 0.5 * g_p * c_2, half_q * q + 0.5 * g_q * c_2
        c_3 = m_0 * size_of(p_3, q_3) + m_p * p_3 + m_q * q_3
        p_4, q_4 = full_p * p + g_p * half_p * c_3, full_q * q + g_q * half_q * c_3
        c_4 = m_0 * size_of(p_4, q_4) + m_p * p_4 + m_q * q_4
        t += step * (FIRST * c_1 + 0.5 * MIDDLE * (c_2 + c_3) + LAST * c_4)
        way_p += step * (FIRST * c_1 * p + 0.5 * MIDDLE * (c_2 * p_2 + c_3 * p_3) + LAST * c_4 * p_4)
        way_q += step * (FIRST * c_1 * q + 0.5 * MIDDLE * (c_2 * q_2 + c_3 * q_3) + LAST * c_4 * q_4)
        p = full_p * p + sixth * b_p * (full_p * c_1 + 2.0 * half_p * (c_2 + c_3) + c_4)
        q = full_q * q + sixth * b_q * (full_q * c_1 + 2.0 * half_q * (c_2 + c_3) + c_4)
    return Turned(False, math.inf, math.inf, 0.0, 0.0, 0.0, 0.0)


@kernel
def go_straight(p, q, rates, b, friction):
    """Follow slip (p, q), m/s, along the axes of A, while it is BESIDE that which gives way most by so little that its
    size is |p|, and all of it falls or grows exponentially: the time, s, slip then, and its way, m.

    rates: of A, 1/kg; b: m/s^2; friction: 1 / (mu N), its mean and by the direction, 1/N.
    """
    (p_rate, q_rate), (b_p, b_q), (mean, by_p, by_q) = rates, b, friction
    side = math.copysign(1.0, p)
    c = mean + side * by_p
    fall = p_rate - side * c * b_p  # of |p|, by tau
    most = BESIDE * abs(p)
    if fall <= q_rate or abs(q) >= most:
        return 0.0, p, q, 0.0, 0.0
    pushed = c * b_q * abs(p) / (fall - q_rate)  # what b holds beside it, and what is there besides
    besides = q + pushed
    if abs(besides) >= most:
        return 0.0, p, q, 0.0, 0.0
    tau = math.log(most / max(abs(besides), TINY)) / (fall - q_rate)
    less_p, less_q = math.exp(-fall * tau), math.exp(-q_rate * tau)
    both = (1.0 - less_p * less_q) / (fall + q_rate)
    twice = (1.0 - less_p * less_p) / (2.0 * fall)
    size = c * abs(p)
    beside = besides * both - pushed * twice
    way_p, way_q = p * (size * twice + by_q * beside), size * beside
    time = size * (1.0 - less_p) / fall + by_q * (besides * (1.0 - less_q) / q_rate - pushed * (1.0 - less_p) / fall)
    return time, p * less_p, besides * less_q - pushed * less_p, way_p, way_q


@kernel
def axes_of(a):
    """The unit vector (h, k) along which a Symmetric is largest, and how large it is along that and across it."""
    mean, half = 0.5 * (a.hh + a.kk), 0.5 * (a.hh - a.kk)
    root = math.sqrt(half * half + a.hk * a.hk)
    h, k = (root + half, a.hk) if half > 0.0 else (a.hk, root - half)
    size = math.sqrt(h * h + k * k)
    h, k = (h / size, k / size) if size > 0.0 else (1.0, 0.0)
    return h, k, mean + root, mean - root


@kernel
def size_of(p, q):
    return math.sqrt(p * p + q * q)


@kernel
def gives_way(machine):
    """Whether all speeds answer to the force of a contact, and at once, as mobility_beside has it."""
    return not machine.follows and not machine.rolling


@kernel
def mobility_beside(parameters, run, w):
    """A of the contact of wheel w, which slips, while others that stick hold (Symmetric, 1/kg)."""
    machine, contacts = parameters.machine, parameters.workspace.contacts
    equations = free_equations(machine, 0.0, 0.0, 0.0)
    for v in range(len(run.mode)):
        if run.mode[v].grip[0] == STICK:
            equations = held_equations(contacts[parameters.wheels[v].contacts], equations)
    wheel = parameters.wheels[w]
    contact = contacts[wheel.contacts]
    state = contact_state(parameters, run.mode[w], w, 0, body_motion(parameters, run.y), run.y)
    j = slip_jacobian(wheel, state.axis, state.contact)
    set_contact(contact, state, j, False)
    set_lever(wheel, contact, state.axis, j)
    return contact_mobility(wheel, contact, inverse(machine, equations))


@kernel
def unresisted(rate, a, force):
    """b by the slip acceleration (Slip, m/s^2) under a friction force (Slip, N)."""
    h, k = applied(a, force.h, force.k)
    return Slip(rate.h - h, rate.k - k)
