"""Drives as numbers: whatever its kind, a drive is asked for gain u - damping phi' + integral z, within its limit.

    torque      u the torque                                    a torque        gain 1
    follow      u the acceleration of the spin that a table of angles asks for, whatever torque that takes
    rate        u the target rate, z the integrated error       a torque        gain = damping = proportional
    dc_motor    u the voltage                                   a voltage       gain 1
                u the target rate, z the integrated error       a voltage       gain = damping = proportional

What a motor makes of its voltage V, at the wheel (actuation.py):

    L I' = V - K phi' - R_a I       tau = K I - b phi' - T phi' / sqrt(phi'^2 + r^2)        K = g k

g gear ratio, k torque constant, R_a resistance, L inductance, b viscosity, T Coulomb friction that changes its sign
over the rate r. The rotor appears at the axle with g^2 times its inertia.
"""

import math
from typing import NamedTuple

from omnisim.base.keeping import kept
from omnisim.scene.drive_schema import DATA_SHEET, Drive

SHEET_TOLERANCE = 0.05  # of the stall torque: data sheets are rounded


class Motor(NamedTuple):
    """A motor as the wheel feels it: K (V s/rad, N m/A), resistance (ohm), inductance (H), largest current (A),
    viscosity (N m s), Coulomb friction (N m) and the rate over which it changes its sign (rad/s)."""

    constant: float
    resistance: float
    inductance: float
    current_limit: float
    viscosity: float
    friction_torque: float
    friction_rate: float


class DriveLaw(NamedTuple):
    """The numbers of a drive: gain (of its demand, N m or V, by unit of u), damping and integral (by rad/s and rad),
    derivative (by rad/s^2), limit of the demand, sample time (s; 0: none), inertia of the rotor at the wheel (kg m^2);
    whether it follows a table of angles.
    """

    gain: float
    damping: float = 0.0
    integral: float = 0.0
    derivative: float = 0.0
    limit: float = math.inf
    sample_time: float = 0.0
    rotor_inertia: float = 0.0
    motor: Motor | None = None
    follows: bool = False

    @property
    def integrates(self) -> bool:
        """Whether the integrated error is a state; that of a sampled controller is a sum."""
        return self.integral > 0.0 and self.sample_time == 0.0


@kept
def drive_law(drive: Drive) -> DriveLaw:
    if drive.kind == "follow":
        return DriveLaw(0.0, follows=True)
    law = DriveLaw(drive.proportional, drive.proportional, drive.integral) if drive.controlled else DriveLaw(1.0)
    if drive.kind != "dc_motor":
        return law._replace(limit=drive.torque_limit)
    return law._replace(
        derivative=drive.derivative,
        limit=voltage_limit(drive),
        sample_time=drive.sample_time or 0.0,
        rotor_inertia=drive.gear_ratio**2 * drive.rotor_inertia,
        motor=motor_of(drive),
    )


def voltage_limit(drive: Drive) -> float:
    """Of a motor, V: a controller has no more than the nominal voltage of a data sheet, unless the scene gives it."""
    if drive.controlled and drive.nominal_voltage and "voltage_limit" not in drive.model_fields_set:
        return drive.nominal_voltage
    return drive.voltage_limit


def motor_of(drive: Drive) -> Motor:
    gear = drive.gear_ratio
    sheet = sheet_constants(drive) if drive.nominal_voltage else None
    return Motor(
        constant=gear * (sheet.torque_constant if sheet else drive.torque_constant),
        resistance=sheet.resistance if sheet else drive.resistance,
        inductance=drive.inductance,
        current_limit=drive.current_limit,
        viscosity=gear**2 * sheet.viscosity if sheet else drive.viscosity,
        friction_torque=gear * sheet.friction_torque if sheet else drive.friction_torque,
        friction_rate=drive.friction_rate,
    )


def standstill_torque(drive: Drive) -> float:
    """Largest torque of a drive whose wheel stands, N m, its friction not taken off: 0 of a free one, infinite without
    a limit."""
    if drive.kind == "free":
        return 0.0
    law = drive_law(drive)
    if law.follows:
        return math.inf
    most = law.limit if drive.controlled else min(max(map(abs, drive.table[1])), law.limit)
    return law.motor.constant * min(most / law.motor.resistance, law.motor.current_limit) if law.motor else most


def friction_torque(drive: Drive) -> float:
    """Coulomb friction of a drive at its wheel, N m."""
    own = drive_law(drive).motor
    return own.friction_torque if own else 0.0


class DataSheet(NamedTuple):
    """What a data sheet says of a motor, at its nominal voltage (V), before its gear: torque (N m) and current (A) at
    standstill, speed (rad/s) and current (A) without load. The order is that of drive_schema.DATA_SHEET."""

    stall_torque: float
    stall_current: float
    no_load_speed: float
    no_load_current: float
    nominal_voltage: float


def data_sheet(drive: Drive) -> DataSheet:
    """Of a motor that is given by it."""
    return DataSheet(*(getattr(drive, key) for key in DATA_SHEET))


class SheetConstants(NamedTuple):
    """What a data sheet makes of a motor before its gear: resistance (ohm), torque constant (N m/A), Coulomb friction
    (N m), viscosity (N m s), and the stall torques (N m) between which friction can be parted into these two."""

    resistance: float
    torque_constant: float
    friction_torque: float
    viscosity: float
    least_stall: float
    most_stall: float

    @property
    def stall_torque(self) -> float:
        """N m: the data sheet's own, up to its rounding."""
        return self.most_stall - self.friction_torque


def sheet_constants(drive: Drive) -> SheetConstants:
    """The constants that a data sheet stands for, by voltage U, stall torque and current T_s, I_s, and no-load speed
    and current w_0, I_0:

        R_a = U / I_s      k = (U - R_a I_0) / w_0      T = k I_s - T_s      b = (k I_0 - T) / w_0

    All torque without load is friction, k I_0, and T is what of it is left at standstill: between all and nothing. The
    stall torque is that of the line of torque over speed, as data sheets have it; at rest itself Coulomb friction is 0.
    """
    sheet = data_sheet(drive)
    resistance = sheet.nominal_voltage / sheet.stall_current
    constant = (sheet.nominal_voltage - resistance * sheet.no_load_current) / sheet.no_load_speed
    most, without_load = constant * sheet.stall_current, constant * sheet.no_load_current
    coulomb = min(max(most - sheet.stall_torque, 0.0), without_load)
    viscosity = (without_load - coulomb) / sheet.no_load_speed
    return SheetConstants(resistance, constant, coulomb, viscosity, most - without_load, most)
