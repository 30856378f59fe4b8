"""Stage 3, what moment: rolling resistance of a roller on the floor, by its load.

    M = -f N w_t / sqrt(|w_t|^2 + r^2)      w_t: angular velocity of the roller in the tangent plane

f: rolling_resistance, m, the lead of the normal force before the middle of the contact; r: rolling_rate, over which M
changes its sign. A roller turns with its wheel and about its own axis, so M is what resists the rolling of both.
"""

import math

from omnisim.base.kernel import kernel
from omnisim.contact.frame import Slip


@kernel
def rolling_moment(wheel, h, k):
    """M / N along h and k (Slip, m) of a roller that turns with (h, k), rad/s, along the floor."""
    scale = -wheel.rolling_resistance / math.sqrt(h * h + k * k + wheel.rolling_rate * wheel.rolling_rate)
    return Slip(scale * h, scale * k)


@kernel
def rolling_relaxation(wheel, h, k):
    """The rate at which M stops such a roller on its wheel, by the normal force, at most, 1/(N s)."""
    size = math.sqrt(h * h + k * k + wheel.rolling_rate * wheel.rolling_rate)
    return wheel.rolling_resistance / size * (wheel.axial_mobility + wheel.spin_mobility)
