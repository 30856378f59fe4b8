"""Cosine and sine together: half of the time of a right-hand side, if they are calls, is spent on them.

Inlined they run beside everything else. The argument is reduced to |r| <= pi / 4 by multiples of pi / 2 in three parts
(Cody & Waite, Software Manual for the Elementary Functions, 1980), then come the polynomials of fdlibm (Sun
Microsystems, 1993: k_cos.c, k_sin.c), whose terms are grouped such that few of them wait for another.
"""

import math
from functools import lru_cache

from omnisim.base.kernel import kernel

EIGHTH_TURN = 0.7853981633974483
TWO_OVER_PI = 0.6366197723675814
TO_INTEGER = 6755399441055744.0  # 1.5 * 2^52: added and taken away again, it rounds
PI_HALVES = (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21)  # of 33, 33, 53 bits
SMALL_ANGLE = 0.03  # rad, of which the eleventh power is none
MOST_TURNS = 2.0**52  # the rounding of more, and of what is no number, has no integer


@kernel
def cos_sin(x):
    """Cosine and sine of x, rad, each to 1e-16 and that of x rounded; exactly even and odd."""
    r, quarter = x, 0
    if abs(x) > EIGHTH_TURN:  # no roller on the floor, unless a wheel has only three
        turns = (x * TWO_OVER_PI + TO_INTEGER) - TO_INTEGER
        r = ((x - turns * PI_HALVES[0]) - turns * PI_HALVES[1]) - turns * PI_HALVES[2]
        quarter = int(turns) if abs(turns) < MOST_TURNS else 0
    z = r * r
    w = z * z
    sine = (-1.66666666666666324348e-01 + z * 8.33333333332248946124e-03) + w * (
        (-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06)
        + w * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
    )
    cosine = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) + w * (
        (2.48015872894767294178e-05 + z * -2.75573143513906633035e-07)
        + w * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    )
    s, c = r + (r * z) * sine, (1.0 - 0.5 * z) + w * cosine
    if quarter == 0:
        return c, s
    if quarter & 1:
        s, c = c, s
    return -c if (quarter + 1) & 2 else c, -s if quarter & 2 else s


@kernel
def angle_of(cos, sin):
    """The angle with this cosine and sine times any positive number, rad; of small ones the series is much faster than
    a call, and exact to rounding."""
    if abs(sin) < SMALL_ANGLE * cos:
        x = sin / cos
        z = x * x
        return x * (1.0 - z * (1.0 / 3.0 - z * (0.2 - z * (1.0 / 7.0 - z * (1.0 / 9.0)))))
    return math.atan2(sin, cos)


@lru_cache
def exact_cos_sin(degrees: float) -> tuple[float, float]:
    """Cosine and sine, exact at multiples of 90 deg, so that symmetric machines are symmetric to the last bit."""
    turns, rest = divmod(degrees, 90.0)
    cos, sin = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(turns) % 4):
        cos, sin = -sin, cos
    return cos, sin
