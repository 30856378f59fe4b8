"""Stage 3, dry friction of a patch that slides and spins at once (Contensou 1963; Zhuravlev 1998 in closed form).

Hertz pressure p = 3 N / (2 pi a^2) sqrt(1 - r^2 / a^2) on a circle of radius a, and at every point mu p dA against the
local slip. That slip turns about one centre, s = v / (a omega) radii from the middle. Along a line through the centre
the force changes nothing but its sign, where the area element rho drho dx changes its own: the integral over a chord
of half length h a is elementary. With x between the chord and the line to the middle, h^2 = 1 - s^2 sin^2 x and

    Phi = 3/4 s int h^2 cos^2 x dx        |F| = mu N Phi
    Psi = 3/16 int h^4 dx                 |M| = mu N a Psi

over all lines that meet the patch: every line for a centre inside (s < 1), where both are polynomials, and
|x| < asin(1 / s) for one outside. Two derivatives agree at s = 1.
"""

import math

from omnisim.base.kernel import kernel

SPINNING_TORQUE = 3.0 * math.pi / 16.0  # Psi without sliding
# for a faint spin k = 1 / s the closed form cancels, by 0.7 / k^4; below this bound Psi = k/5 2F1(1/2, 1/2; 7/2; k^2)
FAINT = 0.3
RATIOS = tuple((2 * n - 1) ** 2 / (2 * n * (2 * n + 5)) for n in range(11, 0, -1))  # of successive coefficients


@kernel
def patch_factors(sliding, spinning):
    """Phi of the force and Psi of the torque for the speeds |v| and a |omega|, m/s, not both zero.

    F = -mu N Phi v / |v| and M = -mu N a Psi omega / |omega|. Only the ratio of the speeds counts.
    """
    if sliding <= spinning:
        s = sliding / spinning
        z = s * s
        return SPINNING_TORQUE * (2.0 - 0.5 * z) * s, SPINNING_TORQUE * (1.0 - z * (1.0 - 0.375 * z))
    k = spinning / sliding
    z = k * k
    square = (1.0 - k) * (1.0 + k)
    cos = math.sqrt(square)
    spread = 3.0 - 8.0 * z * square  # never below 1
    if k < FAINT:
        series = 1.0
        for ratio in RATIOS:
            series = 1.0 + ratio * z * series
        torque = 0.2 * k * series
    else:
        torque = 0.046875 * (spread * math.asin(k) - 3.0 * k * cos * (square - z)) / (z * z)
    # the arc sine eliminated between both integrals, since this form cancels nowhere
    return (3.0 * square * square * cos - 4.0 * k * (1.0 - 4.0 * z) * torque) / spread, torque
