"""Drives as numbers: whatever its kind, a drive gives gain u - damping phi' + integral z, up to its limit.

    torque      u the torque                       gain 1
    rate        u the target rate, z the integrated error       gain = damping = proportional
    dc_motor    u the voltage, I = (u - g k phi') / R_a         gain g k / R_a, damping (g k)^2 / R_a + viscosity

g gear ratio, k torque constant, R_a resistance; the motor's inductance is left out. Its friction comes off beyond the
limit, its rotor appears at the axle with g^2 times its inertia.
"""

import math
from typing import NamedTuple

from omnisim.config import Drive


class DriveLaw(NamedTuple):
    """The numbers of a drive: gain (N m by unit of u), damping (N m s), integral (N m), limit and friction (N m),
    rate over which friction changes its sign (rad/s), reflected inertia of the rotor (kg m^2)."""

    gain: float
    damping: float = 0.0
    integral: float = 0.0
    limit: float = math.inf
    friction_torque: float = 0.0
    friction_rate: float = 0.1
    rotor_inertia: float = 0.0


def drive_law(drive: Drive) -> DriveLaw:
    if drive.kind == "rate":
        return DriveLaw(drive.proportional, drive.proportional, drive.integral, drive.torque_limit)
    if drive.kind == "dc_motor":
        geared = drive.gear_ratio * drive.torque_constant
        return DriveLaw(
            gain=geared / drive.resistance,
            damping=geared**2 / drive.resistance + drive.viscosity,
            friction_torque=drive.friction_torque,
            friction_rate=drive.friction_rate,
            rotor_inertia=drive.gear_ratio**2 * drive.rotor_inertia,
        )
    return DriveLaw(1.0)
