"""Moments of inertia of a wheel with its rollers, as of one body."""

import math

from omnisim.base.keeping import kept
from omnisim.scene.masses import row_shift, wheel_mass
from omnisim.scene.wheel_schema import WheelType


def axle_inertia(kind: WheelType, sin_psi: float) -> float:
    """J_k = I_axle + N_r m_r R1^2 + N_r It (1 - s^2): the wheel about its axle, without the rollers' own Ia."""
    count, roller = kind.rollers, kind.roller
    across = roller.inertia_transverse * (1.0 - sin_psi**2)
    return kind.disk.inertia_axle + count * (roller.mass * kind.roller_distance**2 + across)


def diameter_inertia(kind: WheelType) -> float:
    """J_t = I_diameter + N_r m_r R1^2 / 2 + N_r It (1 - c^2 / 2) + sum m_r offset^2: the wheel about a diameter."""
    count, roller = kind.rollers, kind.roller
    cos_psi = math.cos(math.radians(kind.roller_angle_deg))
    across = roller.inertia_transverse * (1.0 - 0.5 * cos_psi**2)
    inertia = kind.disk.inertia_diameter + count * (0.5 * roller.mass * kind.roller_distance**2 + across)
    return inertia + kind.roller_count * roller.mass * math.fsum(row.offset**2 for row in kind.rows)


@kept
def central_inertia(kind: WheelType) -> float:
    """J_t - m_w o^2: the same about the diameter through its centre of mass, which rows may put aside by o."""
    return diameter_inertia(kind) - wheel_mass(kind) * row_shift(kind) ** 2
