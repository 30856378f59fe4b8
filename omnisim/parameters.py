"""What the kernels know of a scene and never changes: `pack` is the only place where a scene becomes numbers."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from omnisim.config import Config, Friction, Roller, Wheel, WheelType
from omnisim.contact.reaction import LAWS
from omnisim.contact.tracking import TRACKINGS

MACHINE = np.dtype(
    [
        ("gravity", np.float64),  # m/s^2
        ("mass", np.float64),  # M: everything, kg
        ("yaw_inertia", np.float64),  # I_z, kg m^2
        ("law", np.int64),  # reaction.LAWS
        ("friction", np.float64),  # mu, 1
        ("slip_speed", np.float64),  # m/s
        ("viscosity", np.float64),  # N s/m
        ("slip_floor", np.float64),  # slip over which friction changes near zero slip, m/s
        ("patch_radius", np.float64),  # of the contact patch, m; 0: no contact torque
        ("tracking", np.int64),  # tracking.TRACKINGS
        ("bearings", np.int64),  # 1: bearing friction, so that every roller is in the state
        ("bearing_relaxation", np.float64),  # fastest rate at which bearing friction stops a roller, 1/s
        ("slots", np.int64),  # of roller rates in the state, for each wheel
        ("body_frame", np.int64),  # 1: the wrench turns with the yaw
        ("slip_mobility", np.float64),  # upper bound of the contact's inverse mass, 1/kg
    ]
)
WHEEL = np.dtype(
    [
        ("radius", np.float64),  # R, m
        ("roller_distance", np.float64),  # R1, m
        ("rollers", np.int64),  # N_r
        ("alpha", np.float64),  # pi / N_r, rad
        ("sin_alpha", np.float64),
        ("cos_alpha", np.float64),
        ("cos_psi", np.float64),
        ("sin_psi", np.float64),
        ("tan_psi", np.float64),
        ("phase", np.float64),  # azimuth of roller 0 at spin angle 0, rad
        ("axle_inertia", np.float64),  # J_k, kg m^2
        ("axial_inertia", np.float64),  # Ia of one roller, kg m^2
        ("bearing_viscosity", np.float64),  # N m s
        ("bearing_torque", np.float64),  # N m
        ("bearing_rate", np.float64),  # over which the torque changes its sign, rad/s
    ]
)
FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE, DRIVE = range(5)  # channels of the inputs; DRIVE + w is the torque of wheel w
SHORTEST = 1e-14  # relative: pieces of tables that are no longer than rounding are left out


CONTACT = np.dtype(
    [
        ("rest", np.int64),  # at zero slip: its force is sought
        ("limit", np.float64),  # mu N, N
        ("bias", np.float64, (2,)),  # slip acceleration along h and k without any contact's force, m/s^2
        ("force", np.float64, (2,)),  # N
        ("full", np.float64, (2,)),  # friction under the whole load of the wheel while it slips, N
        ("torque", np.float64),  # contact torque under the whole load, N m
        ("lever", np.float64, (2,)),  # of the force, m, and
        ("lean", np.float64),  # of the contact torque, on the spin, 1
    ]
)


class Room(NamedTuple):
    """Room for the solve of C coupled contacts, two for each wheel; not constant, but without memory either.

    contacts: (C,) records CONTACT. mobility (C, C, 2, 2), 1/kg: slip acceleration of one by the force of another.
    """

    contacts: np.recarray
    mobility: np.ndarray


class Parameters(NamedTuple):
    """Constants of a run, W wheels of at most N rollers, S pieces between knots of the tables.

    machine: record MACHINE. wheels: (W,) records WHEEL. sector: (W, N, 2) cosine and sine of 2 pi i / N_r.
    starts: (S,) where the pieces begin, s. inputs: (S, 4 + W, 2) value at the start
    of the piece and slope of every channel. room: Room.
    """

    machine: np.record
    wheels: np.recarray
    sector: np.ndarray
    starts: np.ndarray
    inputs: np.ndarray
    room: Room


def pack(config: Config) -> Parameters:
    """Parameters of a validated scene."""
    types = [config.type_of(wheel) for wheel in config.wheels]
    wheels = [wheel_values(kind, wheel) for kind, wheel in zip(types, config.wheels, strict=True)]
    machine = machine_values(config, types)
    machine["slip_mobility"] = max(slip_mobility_bound(machine, wheel) for wheel in wheels)
    packed, starts_inputs = records(WHEEL, wheels), merge_tables(config)
    return Parameters(
        records(MACHINE, [machine])[0], packed, sectors(packed.rollers), *starts_inputs, room(2 * len(types))
    )


def records(dtype: np.dtype, rows: list[dict]) -> np.recarray:
    """Rows with a value for every field."""
    return np.array([tuple(row[name] for name in dtype.names) for row in rows], dtype).view(np.recarray)


def room(contacts: int) -> Room:
    return Room(np.zeros(contacts, CONTACT).view(np.recarray), np.zeros((contacts, contacts, 2, 2)))


def machine_values(config: Config, types: list[WheelType]) -> dict:
    friction = config.friction
    mass = sum(kind.disk.mass + kind.roller_count * kind.roller.mass for kind in types)
    bearings = any(kind.roller.has_bearing_friction for kind in types)
    return {
        "gravity": config.world.gravity,
        "mass": mass,
        "yaw_inertia": sum(diameter_inertia(kind) for kind in types),
        "law": LAWS[friction.law],
        "friction": friction.coefficient,
        "slip_speed": friction.slip_speed,
        "viscosity": friction.viscosity,
        "slip_floor": slip_floor(friction, mass * config.world.gravity),
        "tracking": TRACKINGS[config.solver.tracking],
        "patch_radius": friction.patch_radius if friction.contact_torque != "none" else 0.0,
        "bearings": bearings,
        "bearing_relaxation": max(bearing_relaxation(kind.roller) for kind in types),
        "slots": max(kind.roller_count for kind in types) if bearings else 2,
        "body_frame": config.wrench.frame == "body",
    }


def slip_floor(friction: Friction, weight: float) -> float:
    """Slip over which friction changes near zero slip, m/s: of viscous friction that at which it carries the weight."""
    if friction.law == "viscous" and friction.viscosity > 0.0:
        return weight / friction.viscosity
    return {"coulomb": 0.0, "regularized": friction.slip_speed, "saturated": friction.slip_speed}.get(friction.law, 1.0)


def bearing_relaxation(roller: Roller) -> float:
    return (roller.bearing_viscosity + roller.bearing_torque / roller.bearing_rate) / roller.inertia_axial


def wheel_values(kind: WheelType, wheel: Wheel) -> dict:
    psi = math.radians(-kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg)
    alpha = math.pi / kind.roller_count
    return {
        "radius": kind.radius,
        "roller_distance": kind.roller_distance,
        "rollers": kind.roller_count,
        "alpha": alpha,
        "sin_alpha": math.sin(alpha),
        "cos_alpha": math.cos(alpha),
        "cos_psi": math.cos(psi),
        "sin_psi": math.sin(psi),
        "tan_psi": math.tan(psi),
        "phase": math.radians(wheel.phase_deg),
        "axle_inertia": axle_inertia(kind, math.sin(psi)),
        "axial_inertia": kind.roller.inertia_axial,
        "bearing_viscosity": kind.roller.bearing_viscosity,
        "bearing_torque": kind.roller.bearing_torque,
        "bearing_rate": kind.roller.bearing_rate,
    }


def axle_inertia(kind: WheelType, sin_psi: float) -> float:
    """J_k = I_axle + N_r m_r R1^2 + N_r It (1 - s^2): the wheel about its axle, without the rollers' own Ia."""
    count, roller = kind.roller_count, kind.roller
    across = roller.inertia_transverse * (1.0 - sin_psi**2)
    return kind.disk.inertia_axle + count * (roller.mass * kind.roller_distance**2 + across)


def diameter_inertia(kind: WheelType) -> float:
    """J_t = I_diameter + N_r m_r R1^2 / 2 + N_r It (1 - c^2 / 2): the wheel about a vertical diameter."""
    count, roller = kind.roller_count, kind.roller
    cos_psi = math.cos(math.radians(kind.roller_angle_deg))
    across = roller.inertia_transverse * (1.0 - 0.5 * cos_psi**2)
    return kind.disk.inertia_diameter + count * (0.5 * roller.mass * kind.roller_distance**2 + across)


def slip_mobility_bound(machine: dict, wheel: dict) -> float:
    """Upper bound of the trace of `kinematics.inverse_mass` over the whole roller, 1/kg.

    Each entry of the Jacobian is bounded by its largest magnitude on [-alpha, alpha].
    """
    radius, distance = wheel["radius"], wheel["roller_distance"]
    h_0, c, s = radius - distance, wheel["cos_psi"], abs(wheel["sin_psi"])
    l = distance * math.tan(wheel["alpha"]) * abs(wheel["tan_psi"])
    spin = (radius + s * s * h_0) ** 2 + (s * c * h_0) ** 2
    yaw = (l + c * wheel["sin_alpha"] * s * h_0) ** 2 + (c * c * wheel["sin_alpha"] * h_0) ** 2
    roller = h_0**2 / wheel["axial_inertia"]
    return 2.0 / machine["mass"] + spin / wheel["axle_inertia"] + yaw / machine["yaw_inertia"] + roller


def sectors(rollers: np.ndarray) -> np.ndarray:
    """Cosine and sine of 2 pi i / N_r, (W, N, 2)."""
    angle = 2.0 * np.pi * np.arange(rollers.max()) / rollers[:, None]
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def merge_tables(config: Config) -> tuple[np.ndarray, np.ndarray]:
    """All tables of a scene on the union of their knots: starts (S,) and inputs (S, channels, 2).

    Between two knots every input is linear, so one number, the current piece, tells all of them; a jump is two
    equal knots, between which no piece lies.
    """
    times, forces, yaw_torques = config.wrench.table
    tables = {FORCE_X + axis: (times, values) for axis, values in enumerate(zip(*forces, strict=True))}
    tables[YAW_TORQUE] = (times, yaw_torques)
    tables |= {DRIVE + number: wheel.drive.table for number, wheel in enumerate(config.wheels)}
    knots = sorted({time for times, _ in tables.values() for time in times if time > 0.0})
    edges = np.array([0.0, *knots, math.inf])
    lasting = np.diff(edges) > SHORTEST * (1.0 + edges[:-1])  # two knots that rounding cannot part are a jump
    starts = edges[:-1][lasting]
    inputs = np.zeros((len(starts), DRIVE + len(config.wheels), 2))
    for channel, (times, values) in tables.items():
        for piece, start in enumerate(starts):
            inputs[piece, channel] = line(times, values, start)
    starts[0] = 0.0
    return starts, inputs


def line(times: Sequence[float], values: Sequence[float], start: float) -> tuple[float, float]:
    """Value at `start` and slope of a table from there to its next knot."""
    after = int(np.searchsorted(times, start, side="right"))  # first knot beyond the start
    if after == 0 or after == len(times):
        return values[min(after, len(times) - 1)], 0.0
    t0, t1, v0, v1 = times[after - 1], times[after], values[after - 1], values[after]
    slope = (v1 - v0) / (t1 - t0)
    return v0 + slope * (start - t0), slope
