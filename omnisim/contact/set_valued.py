"""Stage 3, the set-valued law of Coulomb: |F| <= mu N, and F = -mu N v / |v| when slipping.

At zero slip the force follows from the contact equation v' = b + A F, b the slip acceleration without friction and A
the contact's inverse mass:

    sticking    v' = 0: F = -A^-1 b, as long as it lies inside the cone
    slipping    from rest in the direction u in which it goes on: F = -mu N u and v' = b - mu N A u = kappa u

Both are one principle (Gauss): of all forces inside the cone the contact takes that with the least F.A F / 2 + b.F.
For several contacts, coupled by A, it is a convex problem over discs, and taking them in turn solves it.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import Symmetric, solution

TINY = 1e-300
MOST_SWEEPS = 500
TOLERANCE = 1e-15  # relative change of the forces in a sweep over all contacts, and of kappa in an iteration
MOST_ITERATIONS = 40  # for kappa, of which half a dozen are usual
MOST_TURN = 0.5  # rad, by one Newton correction of a direction
SMALL_PART = 1e-2  # of a correction, that the next one may be for both to be a geometric series
SLIP, STICK, CREEP = 0, 1, 2  # creep: slip so slow that its direction is that of the contact equation


class Direction(NamedTuple):
    """Unit vector u along h and k, and kappa (m/s^2): the growth of slip along it."""

    h: float
    k: float
    kappa: float


@kernel
def sticking_force(a, b):
    """F (h, k), N, that holds the slip: A F = -b for A (Symmetric) in 1/kg and b (h, k) in m/s^2."""
    return solution(a, Slip(-b.h, -b.k))


@kernel
def slip_direction(a, b, limit):
    """The attracting Direction of slip from rest under friction of magnitude `limit` = mu N, N.

    (S + kappa I) u = b with S = limit A and |u| = 1: the largest root kappa, where the left side is positive definite.
    In the eigenvectors of S it is the secular equation sum b_i^2 / (s_i + kappa)^2 = 1; Newton on 1 / |u| = 1, which
    is nearly linear in kappa, from below.
    """
    mean = 0.5 * limit * (a.hh + a.kk)
    half = 0.5 * limit * (a.hh - a.kk)
    off = limit * a.hk
    spread = math.sqrt(half * half + off * off)
    angle = 0.5 * math.atan2(off, half)
    cos, sin = math.cos(angle), math.sin(angle)  # the eigenvector of the larger eigenvalue
    s_1, s_2 = mean + spread, mean - spread
    b_1, b_2 = b.h * cos + b.k * sin, b.k * cos - b.h * sin
    if b_1 == 0.0 and b_2 == 0.0:  # nothing accelerates it
        return Direction(cos, sin, -s_1)
    kappa = max(abs(b_1) - s_1, abs(b_2) - s_2)
    for _ in range(MOST_ITERATIONS):
        u_1, u_2 = b_1 / max(s_1 + kappa, TINY), b_2 / max(s_2 + kappa, TINY)
        square = u_1 * u_1 + u_2 * u_2
        norm = math.sqrt(square)
        descent = u_1 * u_1 / max(s_1 + kappa, TINY) + u_2 * u_2 / max(s_2 + kappa, TINY)
        change = (norm - 1.0) * square / descent
        kappa += change
        if abs(change) <= TOLERANCE * (mean + abs(kappa)):
            break
    u_1, u_2 = b_1 / max(s_1 + kappa, TINY), b_2 / max(s_2 + kappa, TINY)
    norm = math.sqrt(u_1 * u_1 + u_2 * u_2)
    u_1, u_2 = u_1 / norm, u_2 / norm
    return Direction(u_1 * cos - u_2 * sin, u_1 * sin + u_2 * cos, kappa)


@kernel
def turned(u_h, u_k, rate_h, rate_k, across, kappa, last):
    """Unit vector u after a Newton correction towards a direction in which slip is accelerated, and the correction.

    rate: slip acceleration v' under friction against u; kappa: its part along u; across: mu N A across u. Of all
    directions with v' = kappa u those with across + kappa > 0 attract. last: the correction before, 0 if there was
    none; as the load answers, each is a constant small part of the one before, and all that would follow are added.
    """
    if across + kappa <= 0.0:
        return u_h, u_k, 0.0
    correction = (u_h * rate_k - u_k * rate_h) / (across + kappa)
    if abs(correction) < SMALL_PART * abs(last):
        correction *= last / (last - correction)
    correction = min(MOST_TURN, max(-MOST_TURN, correction))
    h, k = u_h - correction * u_k, u_k + correction * u_h
    norm = math.sqrt(h * h + k * k)
    return h / norm, k / norm, correction


@kernel
def contact_forces(contacts, mobility):
    """Forces of contacts (C,), records RESTING, by Gauss' principle; of those that are not at rest as they stand there.

    mobility (C, C, 2, 2), 1/kg. Taken in turn, each contact is in the equation of one with the others' forces in its
    bias; the energy falls with each until the forces settle.
    """
    for _ in range(MOST_SWEEPS):
        change, size, resting = 0.0, 0.0, 0
        for c in range(len(contacts)):
            contact = contacts[c]
            if not contact.rest:
                continue
            resting += 1
            bias_h, bias_k = contact.bias[0], contact.bias[1]
            for d in range(len(contacts)):
                if d != c:
                    a = mobility[c, d]
                    force = contacts[d].force
                    bias_h += a[0, 0] * force[0] + a[0, 1] * force[1]
                    bias_k += a[1, 0] * force[0] + a[1, 1] * force[1]
            a = mobility[c, c]
            force = contact.force
            solved = resting_force(Symmetric(a[0, 0], a[0, 1], a[1, 1]), Slip(bias_h, bias_k), contact.limit)
            change = max(change, max(abs(solved.h - force[0]), abs(solved.k - force[1])))
            size = max(size, max(abs(solved.h), abs(solved.k)))
            force[0], force[1] = solved.h, solved.k
        if resting < 2 or change <= TOLERANCE * size:
            break


@kernel
def resting_force(a, b, limit):
    """F (h, k), N, of one contact at zero slip: that which holds it if the limit mu N allows, else the whole limit."""
    force = sticking_force(a, b)
    if force.h * force.h + force.k * force.k <= limit * limit:
        return force
    u = slip_direction(a, b, limit)
    return Slip(-limit * u.h, -limit * u.k)
