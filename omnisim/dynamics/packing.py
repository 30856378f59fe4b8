"""From a scene to the numbers that kernels know: `pack` is the only place where that happens."""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from omnisim.base.records import blank, records
from omnisim.base.trigonometry import exact_cos_sin
from omnisim.contact.friction import LAWS
from omnisim.contact.mobility import HEAVY
from omnisim.dynamics.inertia import axle_inertia, central_inertia
from omnisim.dynamics.parameters import (
    ARTICULATED,
    CONTACT,
    CONTACTS,
    DRIVE_INPUT,
    FORCE_X,
    FORCE_Y,
    FORCE_Z,
    FREE,
    JOINT,
    LOADS,
    MACHINE,
    PART,
    RESTING,
    ROLLER_ROW,
    SERVO,
    WHEEL,
    YAW_TORQUE,
    Parameters,
    Workspace,
)
from omnisim.dynamics.spatial.packing import carried_wheels, mobility_bound, pack_space
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.state import TOUCHING, Contents, places_in_space, places_of
from omnisim.scene.cubic import cubic_curvature
from omnisim.scene.drives import DriveLaw, Motor, drive_law
from omnisim.scene.ideal_kinematics import inverse, rms_distance, wheel_rows
from omnisim.scene.masses import common_centre, exact_moments, point_masses
from omnisim.scene.schema import Config, Friction, Roller, Wheel, WheelType

SHORTEST = 1e-14  # relative: pieces of tables that are no longer than rounding are left out
UPRIGHT = {"servo": SERVO, "contacts": CONTACTS, "free": FREE}
WRENCH = [FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE]


def pack(config: Config) -> Parameters:
    """Parameters of a validated scene."""
    types = [config.type_of(wheel) for wheel in config.wheels]
    laws = [drive_law(wheel.drive) for wheel in config.wheels]
    rows = wheel_rows(config)
    machine = machine_values(config, types, laws)
    twists = None
    centre, step = machine["centre"].tolist(), config.time.step
    wheels = [
        wheel_values(kind, wheel, law, centre, step)
        for kind, wheel, law in zip(types, config.wheels, laws, strict=True)
    ]
    if config.chassis is not None:
        twists = inverse(rows, rms_distance(config))
    machine["odometry"] = twists is not None
    if twists is not None:
        spin_angles = np.array([wheel.spin_angle for wheel in config.wheels])
        wheels = [wheel | {"odometry": tuple(column)} for wheel, column in zip(wheels, twists.T, strict=True)]
        machine["odometry_yaw"] = math.radians(config.initial.yaw_deg) - twists[2] @ spin_angles
    most = max(kind.rollers for kind in types)
    free = config.upright == "free"
    flags = "integrals", "currents", "bearing_friction", "motors", "odometry"
    machine["places"] = (places_in_space if free else places_of)(
        Contents(
            len(wheels),
            machine["slots"],
            **{flag: int(machine[flag]) for flag in flags},
            rhos=len(wheels) * most if config.solver.tracking == "implicit" else 0,
            bodies=1 + len(wheels) * (1 + most) if config.solver.formulation == "multibody" else 0,
            carriers=len(carried_wheels(config)) if free else 0,
        )
    )
    rates = machine["places"].roller_rate
    firsts = np.cumsum([0, *(len(kind.rows) for kind in types)]).tolist()
    starts = [
        {"rates": rates + machine["slots"] * w, "contacts": TOUCHING * w, "row": firsts[w], "rows": len(kind.rows)}
        for w, kind in enumerate(types)
    ]
    wheels = [wheel | start for wheel, start in zip(wheels, starts, strict=True)]
    for wheel in wheels:
        heavy = 1.0 / (HEAVY * machine["mass"] * wheel["radius"] ** 2)
        wheel["holding_mobility"] = heavy if wheel["follows"] else wheel["spin_mobility"]
    space = pack_space(config, wheels, machine) if free else None
    if space is None:
        bounds = [slip_mobility_bound(machine, wheel, kind) for wheel, kind in zip(wheels, types, strict=True)]
    else:
        bounds = [mobility_bound(space, wheel) for wheel in wheels]
    machine["slip_mobility"] = max(bounds)
    counts = tuple(kind.rollers for kind in types)
    constants = records(MACHINE, [machine])[0], records(WHEEL, wheels), rows_of(wheels, types), sectors(counts).copy()
    return Parameters(*constants, *merge_tables(config, rows), workspace(config, wheels, most), space)


def workspace(config: Config, values: list[dict], rollers: int) -> Workspace:
    """A Workspace for a scene whose wheels have these values."""
    wheels = len(values)
    parts = blank(PART, wheels)
    parts["first"] = [wheel["contacts"] for wheel in values]
    return Workspace(
        contacts=blank(CONTACT, TOUCHING * wheels),
        parts=parts,
        loads=blank(LOADS, 1)[0],
        resting=blank(RESTING, TOUCHING) if config.friction.law == "coulomb" else None,
        articulated=blank(ARTICULATED, wheels) if config.solver.formulation == "multibody" else None,
        joints=blank(JOINT, wheels, rollers + 1),
    )


class Bodies(NamedTuple):
    """What the bodies of a machine make up: M, the common centre of mass (x, y, z), I_z and S about it, SI."""

    mass: float
    centre: np.ndarray
    yaw_inertia: float
    moment: np.ndarray


def bodies(config: Config) -> Bodies:
    """The chassis, and each wheel with its rollers as one body; chassis axes."""
    masses, points = point_masses(config)
    inertias = [central_inertia(config.type_of(wheel)) for wheel in config.wheels]
    if config.chassis is not None:
        inertias.append(config.chassis.inertia[2])
    x_centre, y_centre, height = common_centre(masses, points)
    planar = [(x - x_centre, y - y_centre) for x, y, _ in points]
    yaw_inertia = math.fsum(inertias) + math.fsum(m * (x * x + y * y) for m, (x, y) in zip(masses, planar, strict=True))
    lifted = [m * z for m, (_, _, z) in zip(masses, points, strict=True)]
    moment = np.array(exact_moments(lifted, planar))
    return Bodies(math.fsum(masses), np.array([x_centre, y_centre, height]), yaw_inertia, moment)


def machine_values(config: Config, types: list[WheelType], laws: list[DriveLaw]) -> dict:
    """Values of the MACHINE record, but those that take all wheels to know."""
    friction = config.friction
    whole = bodies(config)
    bearing_friction = any(kind.roller.has_bearing_friction for kind in types)
    every_rate = bearing_friction or config.solver.formulation == "multibody"
    along, normal = gravity(config)
    motors = [law.motor for law in laws if law.motor]
    at_centre = np.array([0.0, 0.0, whole.centre[2]])  # of a bare wheel
    pushed = at_centre if config.chassis is None else np.array(config.chassis.center_of_mass)
    return {
        "gravity": normal,
        "downhill": along,
        "inclined": any(along),
        "mass": whole.mass,
        "mobility": 1.0 / whole.mass,
        "yaw_inertia": whole.yaw_inertia,
        "yaw_mobility": 1.0 / whole.yaw_inertia,
        "height": whole.centre[2],
        "moment": whole.moment,
        "centre": whole.centre[:2],
        "lever": pushed - whole.centre,
        "upright": UPRIGHT[config.upright],
        "law": LAWS[friction.law],
        "friction": friction.coefficient,
        "slip_speed": friction.slip_speed,
        "creep_stiffness": friction.creep_stiffness,
        "viscosity": friction.viscosity,
        "slip_floor": slip_floor(friction, whole.mass * normal),
        "patch_radius": friction.patch_radius if friction.contact_torque != "none" else 0.0,
        "implicit_tracking": config.solver.tracking == "implicit",
        "chassis_mass": config.chassis.mass if config.chassis else 0.0,
        "chassis_inertia": config.chassis.inertia if config.chassis else (0.0, 0.0, 0.0),
        "bearing_friction": bearing_friction,
        "every_rate": every_rate,
        "bearing_relaxation": max(bearing_relaxation(kind.roller) for kind in types),
        "slots": slots(config, types, every_rate),
        "integrals": any(law.integrates for law in laws),
        "motors": bool(motors),
        "currents": any(motor.inductance > 0.0 for motor in motors),
        "current_relaxation": max((m.resistance / m.inductance for m in motors if m.inductance > 0.0), default=0.0),
        "follows": any(law.follows for law in laws),
        "sampled": any(law.sample_time > 0.0 for law in laws),
        "odometry_yaw": 0.0,
        "pushed": any(any(force) or torque for force, torque in zip(*config.wrench.table[1:], strict=True)),
        "body_frame": config.wrench.frame == "body",
    }


def slots(config: Config, types: list[WheelType], every_rate: bool) -> int:
    """Of roller rates in the state, for each wheel."""
    if every_rate:
        return max(kind.rollers for kind in types)
    return SLOTS if config.upright == "free" else TOUCHING


def gravity(config: Config) -> tuple[tuple[float, float], float]:
    """What of gravity lies along the floor, world x and y, and what is normal to it, downwards; m/s^2."""
    slope = math.radians(config.floor.slope_deg)
    size = config.world.gravity
    cos, sin = exact_cos_sin(config.floor.uphill_deg)
    downhill = size * math.sin(slope)
    return (-downhill * cos + 0.0, -downhill * sin + 0.0), size * math.cos(slope)


def slip_floor(friction: Friction, weight: float) -> float:
    """Slip over which friction changes near zero slip, m/s: of viscous friction that at which it carries the weight."""
    if friction.law == "viscous" and friction.viscosity > 0.0:
        return weight / friction.viscosity
    if friction.law == "brush":
        return friction.coefficient / friction.creep_stiffness * friction.slip_speed
    return {"coulomb": 0.0, "regularized": friction.slip_speed, "saturated": friction.slip_speed}.get(friction.law, 1.0)


def bearing_relaxation(roller: Roller) -> float:
    return (roller.bearing_viscosity + roller.bearing_torque / roller.bearing_rate) / roller.inertia_axial


def wheel_values(
    kind: WheelType, wheel: Wheel, law: DriveLaw, centre: Sequence[float], step: float | None = None
) -> dict:
    """Values of a WHEEL record; centre: of the machine's mass, chassis axes, m; step: s, None where nothing marches."""
    cos, sin = exact_cos_sin(wheel.heading_deg)
    psi = math.radians(-kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg)
    alpha = kind.covered
    axle = axle_inertia(kind, math.sin(psi))
    x, y = wheel.position[0] - centre[0], wheel.position[1] - centre[1]
    return {
        "cos_heading": cos,
        "sin_heading": sin,
        "offset": (x * cos + y * sin, y * cos - x * sin),
        "radius": kind.radius,
        "roller_distance": kind.roller_distance,
        "rollers": kind.rollers,
        "alpha": alpha,
        "sin_alpha": math.sin(alpha),
        "cos_alpha": math.cos(alpha),
        "cos_psi": math.cos(psi),
        "sin_psi": math.sin(psi),
        "tan_psi": math.tan(psi),
        "phase": math.radians(wheel.phase_deg + kind.rows[0].phase_deg),
        "axle_inertia": axle,
        "rotor_inertia": law.rotor_inertia,
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
        "odometry": (0.0, 0.0, 0.0),
        **drive_values(law, step),
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


def slip_mobility_bound(machine: dict, wheel: dict, kind: WheelType) -> float:
    """Upper bound of the trace of `mobility.inverse_mass` over the whole roller, on any row, 1/kg.

    Each entry of the Jacobian is bounded by its largest magnitude on [-alpha, alpha].
    """
    radius, distance = wheel["radius"], wheel["roller_distance"]
    h_0 = radius - distance
    c = wheel["cos_psi"]
    s = abs(wheel["sin_psi"])
    l = distance * math.tan(wheel["alpha"]) * abs(wheel["tan_psi"]) + max(abs(row.offset) for row in kind.rows)
    spin = (radius + s * s * h_0) ** 2 + (s * c * h_0) ** 2
    e_h, e_k = map(abs, wheel["offset"])
    yaw = (e_k + l + c * wheel["sin_alpha"] * s * h_0) ** 2 + (e_h + c * c * wheel["sin_alpha"] * h_0) ** 2
    roller = h_0**2 * wheel["axial_mobility"]
    return 2.0 / machine["mass"] + spin * wheel["spin_mobility"] + yaw / machine["yaw_inertia"] + roller


def rows_of(wheels: list[dict], types: list[WheelType]) -> np.recarray:
    """The rows of rollers of wheels with these values, records ROLLER_ROW."""
    rows = [
        {"phase": wheel["phase"], "offset": row.offset}
        for wheel, kind in zip(wheels, types, strict=True)
        for row in kind.rings
    ]
    return records(ROLLER_ROW, rows)


@lru_cache
def sectors(rollers: tuple[int, ...]) -> np.ndarray:
    """Cosine and sine of 2 pi i / N_r, (W, N, 2)."""
    angle = 2.0 * np.pi * np.arange(max(rollers)) / np.array(rollers)[:, None]
    sector = np.empty((*angle.shape, 2))
    sector[..., 0], sector[..., 1] = np.cos(angle), np.sin(angle)
    return sector


Table = tuple[tuple[float, ...], tuple[Any, ...]]  # times and values


def merge_tables(config: Config, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All tables of a scene on the union of their knots: starts (S,) and inputs (S, channels, 2).

    Between two knots every input is linear, so one number, the current piece, tells all of them; a jump is two
    equal knots, between which no piece lies. rows: of the ideal machine.
    """
    times, forces, yaw_torques = config.wrench.table
    wrench = times, tuple((*force, torque) for force, torque in zip(forces, yaw_torques, strict=True))
    command = (config.command.times, config.command.twist) if config.command else None
    drives = tuple(None if wheel.drive.follows_command else drive_table(wheel) for wheel in config.wheels)
    starts, inputs = merged(wrench, command, drives, rows.tobytes())
    return starts.copy(), inputs.copy()


def drive_table(wheel: Wheel) -> Table:
    """What the drive of a wheel is given, by time: of one that follows angles the accelerations that they ask for."""
    drive = wheel.drive
    if drive.kind != "follow":
        return drive.table
    return drive.times, tuple(cubic_curvature(drive.times, drive.angle, wheel.spin_rate))


@lru_cache(maxsize=4)  # tables may be long; variants of a machine have the same again and again
def merged(
    wrench: Table, command: Table | None, drives: tuple[Table | None, ...], rows: bytes
) -> tuple[np.ndarray, np.ndarray]:
    """The same of a wrench, a command and a table for each drive, None for one that follows the command."""
    found = list(tables(wrench, command, drives, np.frombuffer(rows).reshape(len(drives), -1)))
    knots = sorted({time for _, times, _ in found for time in times if time > 0.0})
    edges = np.array([0.0, *knots, math.inf])
    lasting = edges[1:] - edges[:-1] > SHORTEST * (1.0 + edges[:-1])  # knots that rounding cannot part are a jump
    starts = edges[:-1][lasting]
    inputs = np.zeros((len(starts), DRIVE_INPUT + len(drives), 2))
    for channels, times, values in found:
        if len(times) == 1:
            inputs[:, channels, 0] = values
        else:
            inputs[:, channels, 0], inputs[:, channels, 1] = lines(np.array(times), np.array(values), starts)
    starts[0] = 0.0
    return starts, inputs


def tables(
    wrench: Table, command: Table | None, drives: tuple[Table | None, ...], rows: np.ndarray
) -> Iterator[tuple[list[int], Sequence[float], Sequence[Sequence[float]]]]:
    """Channels, times and the values of these channels (K, C) of every table."""
    yield WRENCH, *wrench
    followers = [w for w, table in enumerate(drives) if table is None]
    if followers and command:
        times, twists = command
        rates = [[rows[w] @ twist for w in followers] for twist in np.array(twists)]  # of an ideal machine
        yield [DRIVE_INPUT + w for w in followers], times, rates
    for w, table in enumerate(drives):
        if table is not None:
            yield [DRIVE_INPUT + w], table[0], [[value] for value in table[1]]


def lines(times: np.ndarray, values: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of a table (K, C) at each of `starts` and slopes from there to its next knot (S, C); held outside."""
    after = times.searchsorted(starts, side="right")  # first knot beyond each start
    last, first = np.maximum(after - 1, 0), np.minimum(after, len(times) - 1)
    rise = values[first] - values[last]
    length = (times[first] - times[last])[:, None]
    slopes = np.divide(rise, length, out=np.zeros(rise.shape), where=length > 0.0)
    return values[last] + slopes * (starts - times[last])[:, None], slopes
