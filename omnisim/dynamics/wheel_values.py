"""From a wheel of a scene to the numbers that kernels know of it: values of its WHEEL record."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from omnisim.base.keeping import kept
from omnisim.base.records import recorded, records
from omnisim.base.trigonometry import exact_cos_sin
from omnisim.dynamics.inertia import axle_inertia, diameter_inertia
from omnisim.dynamics.parameters import WHEEL
from omnisim.dynamics.state import TOUCHING, Places
from omnisim.scene.drives import DriveLaw, Motor
from omnisim.scene.masses import row_shift, wheel_mass
from omnisim.scene.schema import Wheel
from omnisim.scene.wheel_schema import Roller, WheelType

# What tells where a wheel heads, and what follows from its place in the machine; all else many wheels share.
HEADING = {"cos_heading": 1.0, "sin_heading": 0.0, "odometry": (0.0, 0.0, 0.0)}
OWN = ("offset", "phase", "holding_mobility")


@kept
def shared_values(kind: WheelType, law: DriveLaw, mirrored: bool, step: float | None) -> dict:
    """Those that wheels of one type and with one drive share, if they have the same hand."""
    psi = math.radians(-kind.roller_angle_deg if mirrored else kind.roller_angle_deg)
    alpha = kind.covered
    axle = axle_inertia(kind, math.sin(psi))
    return {
        "radius": kind.radius,
        "roller_distance": kind.roller_distance,
        "rollers": kind.rollers,
        "alpha": alpha,
        "sin_alpha": math.sin(alpha),
        "cos_alpha": math.cos(alpha),
        "cos_psi": math.cos(psi),
        "sin_psi": math.sin(psi),
        "tan_psi": math.tan(psi),
        "axle_inertia": axle,
        "rotor_inertia": law.rotor_inertia,
        "mass": wheel_mass(kind),
        "shift": row_shift(kind),
        "diameter_inertia": diameter_inertia(kind),
        "disk_mass": kind.disk.mass,
        "disk_inertia": (kind.disk.inertia_diameter, kind.disk.inertia_axle),
        "roller_mass": kind.roller.mass,
        "transverse_inertia": kind.roller.inertia_transverse,
        "axial_inertia": kind.roller.inertia_axial,
        "rotor_part": 1.0 if law.follows else law.rotor_inertia / (axle + law.rotor_inertia),
        "spin_mobility": 0.0 if law.follows else 1.0 / (axle + law.rotor_inertia),
        "follows": law.follows,
        "axial_mobility": 1.0 / kind.roller.inertia_axial,
        "bearing_viscosity": kind.roller.bearing_viscosity,
        "bearing_torque": kind.roller.bearing_torque,
        "bearing_rate": kind.roller.bearing_rate,
        "rolling_resistance": kind.roller.rolling_resistance,
        "rolling_rate": kind.roller.rolling_rate,
        **drive_values(law, step),
    }


def heading_values(wheel: Wheel) -> dict:
    """Those of HEADING. Its odometry is still to be found."""
    cos, sin = exact_cos_sin(wheel.heading_deg)
    return HEADING | {"cos_heading": cos, "sin_heading": sin}


def placed_values(kind: WheelType, wheel: Wheel, heading: dict, centre: Sequence[float]) -> dict:
    """Those that are its OWN; centre: of the machine's mass, chassis axes, m. Its holding mobility is still to be
    found."""
    cos, sin = heading["cos_heading"], heading["sin_heading"]
    x, y = wheel.position[0] - centre[0], wheel.position[1] - centre[1]
    return {
        "offset": (x * cos + y * sin, y * cos - x * sin),
        "phase": math.radians(wheel.phase_deg + kind.rows[0].phase_deg),
        "holding_mobility": 0.0,
    }


def drive_values(law: DriveLaw, step: float | None) -> dict:
    """Values of a WHEEL record that tell its drive; step: None if it is not known yet."""
    motor = law.motor or Motor(0.0, 1.0, 0.0, math.inf, 0.0, 0.0, 1.0)
    return {
        "drive_gain": law.gain,
        "drive_damping": law.damping,
        "drive_integral": law.integral,
        "drive_derivative": law.derivative,
        "drive_limit": law.limit,
        "sample_time": law.sample_time,
        "sample_steps": round(law.sample_time / step) if step else 0,
        "motor": law.motor is not None,
        "motor_constant": motor.constant,
        "resistance": motor.resistance,
        "inductance": motor.inductance,
        "current_limit": motor.current_limit,
        "drive_viscosity": motor.viscosity,
        "drive_friction": motor.friction_torque,
        "drive_friction_rate": motor.friction_rate,
    }


def bearing_relaxation(roller: Roller) -> float:
    """Fastest rate at which friction of its bearing stops a roller, 1/s."""
    return (roller.bearing_viscosity + roller.bearing_torque / roller.bearing_rate) / roller.inertia_axial


def wheel_records(content: bytes, names: Iterable[str], wheels: list[dict]) -> np.recarray:
    """Records WHEEL with these bytes, but for the fields of these names."""
    found = np.frombuffer(bytearray(content), recorded(WHEEL))
    for name in names:
        found[name] = [wheel[name] for wheel in wheels]
    return found.view(np.recarray)


@kept
def shared_records(slots: int, places: Places, *known: Any) -> bytes:
    """Bytes of records WHEEL with zeros in the place of what tells where a wheel stands and what is its OWN; known:
    `shared_values` of all wheels, then their types."""
    count = len(known) // 2
    shared, rows = known[:count], [len(kind.rows) for kind in known[count:]]
    none = {"offset": (0.0, 0.0), "phase": 0.0, "holding_mobility": 0.0, **HEADING}
    starts = [
        {
            "rates": places.roller_rate + slots * w,
            "contacts": TOUCHING * w,
            "row": sum(rows[:w]),
            "rows": rows[w],
        }
        for w in range(count)
    ]
    return records(WHEEL, [none | values | start for values, start in zip(shared, starts, strict=True)]).tobytes()


class Reach(NamedTuple):
    """What bounds the inverse mass of a contact on a wheel: by its spin and its roller, 1/kg; where it may be, m."""

    spin: float
    roller: float
    axial: float
    across: float
    along: float


def reach(wheel: dict, kind: WheelType) -> Reach:
    """The same of a wheel with these `shared_values`."""
    radius, distance = wheel["radius"], wheel["roller_distance"]
    h_0 = radius - distance
    c = wheel["cos_psi"]
    s = abs(wheel["sin_psi"])
    spin = (radius + s * s * h_0) ** 2 + (s * c * h_0) ** 2
    return Reach(
        spin=spin * wheel["spin_mobility"],
        roller=h_0**2 * wheel["axial_mobility"],
        axial=distance * math.tan(wheel["alpha"]) * abs(wheel["tan_psi"]) + max(abs(row.offset) for row in kind.rows),
        across=c * wheel["sin_alpha"] * s * h_0,
        along=c * c * wheel["sin_alpha"] * h_0,
    )


def slip_mobility_bound(machine: dict, offset: Sequence[float], found: Reach) -> float:
    """Upper bound of the trace of `mobility.inverse_mass` over the whole roller, on any row, 1/kg; offset: of a wheel
    from the centre of mass, along and across its heading, m.

    Each entry of the Jacobian is bounded by its largest magnitude on [-alpha, alpha].
    """
    e_h, e_k = map(abs, offset)
    yaw = (e_k + found.axial + found.across) ** 2 + (e_h + found.along) ** 2
    return 2.0 / machine["mass"] + found.spin + yaw / machine["yaw_inertia"] + found.roller
