"""What the kernels know of a scene and never changes: `pack` is the only place where a scene becomes numbers."""

import math
from collections.abc import Iterator, Sequence
from operator import mul
from typing import NamedTuple

import numpy as np

from omnisim.config import Config, Friction, Roller, Wheel, WheelType
from omnisim.contact.reaction import LAWS
from omnisim.contact.tracking import TRACKINGS
from omnisim.drives import drive_law
from omnisim.ideal import inverse, rms_distance, wheel_rows
from omnisim.records import blank, records

MACHINE = np.dtype(
    [
        ("gravity", np.float64),  # m/s^2
        ("mass", np.float64),  # M: everything, kg
        ("yaw_inertia", np.float64),  # I_z, kg m^2
        ("height", np.float64),  # z_C: of the common centre of mass C, m
        ("moment", np.float64, (2,)),  # S = sum m z e, chassis axes, kg m^2
        ("centre", np.float64, (2,)),  # C from the chassis origin, chassis axes, m
        ("lever", np.float64, (3,)),  # r: from C to where the wrench acts, chassis axes, m
        ("upright", np.int64),  # SERVO or CONTACTS: what carries roll and pitch
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
        ("integrals", np.int64),  # 1: drives integrate the error of their rate, a state for each wheel
        ("odometry", np.int64),  # 1: the ideal kinematics of the wheels tell a pose
        ("odometry_yaw", np.float64),  # of that pose at spin angles 0, rad
        ("body_frame", np.int64),  # 1: the wrench turns with the yaw
        ("slip_mobility", np.float64),  # upper bound of the contact's inverse mass, 1/kg
    ]
)
WHEEL = np.dtype(
    [
        ("cos_heading", np.float64),  # of h from chassis x
        ("sin_heading", np.float64),
        ("offset", np.float64, (2,)),  # e: of the wheel centre from C, along h and k, m
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
        ("rotor_inertia", np.float64),  # of the motor, reflected to the axle, kg m^2
        ("axial_inertia", np.float64),  # Ia of one roller, kg m^2
        ("spin_mobility", np.float64),  # 1 / (J_k + rotor): of what the drive has to turn, 1/(kg m^2)
        ("axial_mobility", np.float64),  # 1 / Ia, 1/(kg m^2)
        ("bearing_viscosity", np.float64),  # N m s
        ("bearing_torque", np.float64),  # N m
        ("bearing_rate", np.float64),  # over which the torque changes its sign, rad/s
        ("drive_gain", np.float64),  # torque by the input of the drive
        ("drive_damping", np.float64),  # by the spin rate, N m s
        ("drive_integral", np.float64),  # by the integrated error of the spin rate, N m
        ("drive_limit", np.float64),  # of what these three command, N m
        ("drive_friction", np.float64),  # N m
        ("drive_friction_rate", np.float64),  # over which that changes its sign, rad/s
        ("odometry", np.float64, (3,)),  # chassis twist by the spin rate: m, m, 1
    ]
)
FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE, DRIVE = range(5)  # channels of the inputs; DRIVE + w is the drive of wheel w
WRENCH = [FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE]
SHORTEST = 1e-14  # relative: pieces of tables that are no longer than rounding are left out
SERVO, CONTACTS = 0, 1
UPRIGHT = {"servo": SERVO, "contacts": CONTACTS}

# What the right-hand side finds at a contact (two of each wheel) and at a wheel.
CONTACT = np.dtype(
    [
        ("rest", np.int64),  # at zero slip
        ("axis", np.float64, (3,)),  # of the roller, along h, k and n
        ("l", np.float64),  # where it is along the axle, m
        ("slip", np.float64, (2,)),  # along h and k, m/s
        ("turn", np.float64),  # of the roller about the normal, rad/s
        ("arm", np.float64, (2,)),  # slip by the roller's rate, and torque of the force on the roller, m
        ("spin", np.float64, (2,)),  # the same of the spin, m
        ("lever", np.float64, (5, 2)),  # of the force in the rows of body.py
        ("twist", np.float64, (5,)),  # of the contact torque there
        ("mass", np.float64, (3,)),  # E (hh, hk, kk), kg: F = -E v' keeps the slip, as far as spin and roller can
        ("bias", np.float64, (2,)),  # slip acceleration without its force and the body's acceleration, m/s^2
        ("factor", np.float64),  # g of the friction law F = -g v, by the normal force; of viscous friction N s/m
        ("unit", np.float64, (2,)),  # friction of its slip by the normal force, 1
        ("unit_torque", np.float64),  # contact torque by the normal force, m
        ("constant", np.float64, (2,)),  # friction that does not depend on the normal force, N
        ("creep", np.float64, (2,)),  # direction of creeping slip
        ("turned", np.float64),  # by the last correction in the search for it, rad
        ("force", np.float64, (2,)),  # of the floor on the roller, N
        ("torque", np.float64),  # about the normal, N m
        ("share", np.float64),  # of the load of its wheel, 1
    ]
)
PART = np.dtype(
    [
        ("loaded", np.int64),  # 1: the floor carries the wheel
        ("contacts", np.int64),  # 1, or 2 while it rests on two rollers
        ("known", np.int64),  # 1: its forces follow from its own slip, its load being known
        ("sought", np.int64),  # 1: its forces are sought by iteration, see coupled.py
        ("point", np.float64, (2,)),  # where it does, from C along chassis axes, m
        ("drive_torque", np.float64),  # tau on the disk about k, N m
        ("free_spin", np.float64),  # J phi'' without the contacts, N m
        ("heading_moment", np.float64),  # of the wheel on the body without its contacts, about its heading, N m
        ("normal_force", np.float64),  # N, N; below 0 of a wheel that the floor does not carry
        ("share_margin", np.float64),  # torque with which both contacts alone would push back to the edge, N m
    ]
)


EXTERNAL = np.dtype(
    [
        ("x", np.float64),  # force, along chassis axes, N
        ("y", np.float64),
        ("z", np.float64),
        ("yaw_rate", np.float64),  # of the body, rad/s
    ]
)
LOADS = np.dtype(
    [
        ("external", EXTERNAL),
        ("pushes", np.float64, (3, 3)),  # plane rows by the unknowns b of the loads, see body.py
        ("tilt", np.float64, (2, 7)),  # rows of tilt by acceleration, loads, and their right sides
        ("sums", np.float64, (6,)),  # of 1, x, y, x^2, x y, y^2 over the loaded wheels
        ("mobility", np.float64, (2, 2, 2, 2)),  # 1/kg: slip acceleration of one of RESTING by the force of another
    ]
)
RESTING = np.dtype(
    [
        ("rest", np.int64),  # its force is sought
        ("limit", np.float64),  # of the force, N
        ("bias", np.float64, (2,)),  # slip acceleration without the force of any of them, m/s^2
        ("force", np.float64, (2,)),  # N
    ]
)


class Room(NamedTuple):
    """Room for the forces of an instant, W wheels; not constant, but without memory either.

    contacts: (2 W,) records CONTACT, two for each wheel. parts: (W,) records PART. loads: record LOADS. resting (2,):
    records RESTING of the contacts of one wheel.
    """

    contacts: np.recarray
    parts: np.recarray
    loads: np.record
    resting: np.recarray


class Parameters(NamedTuple):
    """Constants of a run, W wheels of at most N rollers, S pieces between knots of the tables.

    machine: record MACHINE. wheels: (W,) records WHEEL. sector: (W, N, 2) cosine and sine of 2 pi i / N_r.
    starts: (S,) where the pieces begin, s. inputs: (S, 4 + W, 2) value at the start of the piece and slope of every
    channel. room: Room.
    """

    machine: np.record
    wheels: np.recarray
    sector: np.ndarray
    starts: np.ndarray
    inputs: np.ndarray
    room: Room


def pack(config: Config) -> Parameters:
    """Parameters of a validated scene."""
    types, rows = [config.type_of(wheel) for wheel in config.wheels], wheel_rows(config)
    machine, twists = machine_values(config, types), None
    wheels = [wheel_values(*pair, machine["centre"]) for pair in zip(types, config.wheels, strict=True)]
    if config.chassis is not None:
        twists = inverse(rows, rms_distance(config))
    machine["odometry"] = twists is not None
    if twists is not None:
        starts = np.radians([wheel.spin_angle_deg for wheel in config.wheels])
        wheels = [wheel | {"odometry": tuple(column)} for wheel, column in zip(wheels, twists.T, strict=True)]
        machine["odometry_yaw"] = math.radians(config.initial.yaw_deg) - twists[2] @ starts
    machine["slip_mobility"] = max(slip_mobility_bound(machine, wheel) for wheel in wheels)
    packed, starts_inputs = records(WHEEL, wheels), merge_tables(config, rows)
    return Parameters(records(MACHINE, [machine])[0], packed, sectors(packed.rollers), *starts_inputs, room(len(types)))


def room(wheels: int) -> Room:
    return Room(blank(CONTACT, 2 * wheels), blank(PART, wheels), blank(LOADS, 1)[0], blank(RESTING, 2))


class Bodies(NamedTuple):
    """What the bodies of a machine make up: M, the common centre of mass (x, y, z), I_z and S about it, SI."""

    mass: float
    centre: np.ndarray
    yaw_inertia: float
    moment: np.ndarray


def bodies(config: Config) -> Bodies:
    """The chassis, and each wheel with its rollers as one body at the wheel centre; chassis axes."""
    types = [config.type_of(wheel) for wheel in config.wheels]
    masses = [kind.disk.mass + kind.roller_count * kind.roller.mass for kind in types]
    points = [(*wheel.position, kind.radius) for wheel, kind in zip(config.wheels, types, strict=True)]
    inertias = [diameter_inertia(kind) for kind in types]
    if config.chassis is not None:
        masses.append(config.chassis.mass)
        points.append(config.chassis.center_of_mass)
        inertias.append(config.chassis.inertia[2])
    whole = math.fsum(masses)
    x_centre, y_centre, height = (moment / whole for moment in exact_moments(masses, points))
    planar = [(x - x_centre, y - y_centre) for x, y, _ in points]
    yaw_inertia = math.fsum(inertias) + math.fsum(m * (x * x + y * y) for m, (x, y) in zip(masses, planar, strict=True))
    lifted = [m * z for m, (_, _, z) in zip(masses, points, strict=True)]
    moment = np.array(exact_moments(lifted, planar))
    return Bodies(whole, np.array([x_centre, y_centre, height]), yaw_inertia, moment)


def exact_moments(masses: Sequence[float], points: Sequence[Sequence[float]]) -> list[float]:
    """Sum of m p, rounded once: what cancels in a symmetric machine cancels to the last bit."""
    return [math.fsum(map(mul, masses, column)) for column in zip(*points, strict=True)]


def machine_values(config: Config, types: list[WheelType]) -> dict:
    """Values of the MACHINE record, but those that take all wheels to know."""
    friction, whole = config.friction, bodies(config)
    bearings = any(kind.roller.has_bearing_friction for kind in types)
    pushed = whole.centre if config.chassis is None else np.array(config.chassis.center_of_mass)
    return {
        "gravity": config.world.gravity,
        "mass": whole.mass,
        "yaw_inertia": whole.yaw_inertia,
        "height": whole.centre[2],
        "moment": whole.moment,
        "centre": whole.centre[:2],
        "lever": pushed - whole.centre,
        "upright": UPRIGHT[config.upright],
        "law": LAWS[friction.law],
        "friction": friction.coefficient,
        "slip_speed": friction.slip_speed,
        "viscosity": friction.viscosity,
        "slip_floor": slip_floor(friction, whole.mass * config.world.gravity),
        "tracking": TRACKINGS[config.solver.tracking],
        "patch_radius": friction.patch_radius if friction.contact_torque != "none" else 0.0,
        "bearings": bearings,
        "bearing_relaxation": max(bearing_relaxation(kind.roller) for kind in types),
        "slots": max(kind.roller_count for kind in types) if bearings else 2,
        "integrals": any(drive_law(wheel.drive).integral > 0.0 for wheel in config.wheels),
        "odometry_yaw": 0.0,
        "body_frame": config.wrench.frame == "body",
    }


def slip_floor(friction: Friction, weight: float) -> float:
    """Slip over which friction changes near zero slip, m/s: of viscous friction that at which it carries the weight."""
    if friction.law == "viscous" and friction.viscosity > 0.0:
        return weight / friction.viscosity
    return {"coulomb": 0.0, "regularized": friction.slip_speed, "saturated": friction.slip_speed}.get(friction.law, 1.0)


def bearing_relaxation(roller: Roller) -> float:
    return (roller.bearing_viscosity + roller.bearing_torque / roller.bearing_rate) / roller.inertia_axial


def wheel_values(kind: WheelType, wheel: Wheel, centre: np.ndarray) -> dict:
    """Values of a WHEEL record; centre: of the machine's mass, chassis axes, m."""
    law = drive_law(wheel.drive)
    cos, sin = exact_cos_sin(wheel.heading_deg)
    psi = math.radians(-kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg)
    alpha, axle = math.pi / kind.roller_count, axle_inertia(kind, math.sin(psi))
    from_centre = np.array(wheel.position) - centre
    return {
        "cos_heading": cos,
        "sin_heading": sin,
        "offset": (from_centre @ (cos, sin), from_centre @ (-sin, cos)),
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
        "axle_inertia": axle,
        "rotor_inertia": law.rotor_inertia,
        "axial_inertia": kind.roller.inertia_axial,
        "spin_mobility": 1.0 / (axle + law.rotor_inertia),
        "axial_mobility": 1.0 / kind.roller.inertia_axial,
        "bearing_viscosity": kind.roller.bearing_viscosity,
        "bearing_torque": kind.roller.bearing_torque,
        "bearing_rate": kind.roller.bearing_rate,
        "drive_gain": law.gain,
        "drive_damping": law.damping,
        "drive_integral": law.integral,
        "drive_limit": law.limit,
        "drive_friction": law.friction_torque,
        "drive_friction_rate": law.friction_rate,
        "odometry": (0.0, 0.0, 0.0),
    }


def exact_cos_sin(degrees: float) -> tuple[float, float]:
    """Cosine and sine, exact at multiples of 90 deg, so that symmetric machines are symmetric to the last bit."""
    turns, rest = divmod(degrees, 90.0)
    cos, sin = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(turns) % 4):
        cos, sin = -sin, cos
    return cos, sin


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
    e_h, e_k = map(abs, wheel["offset"])
    yaw = (e_k + l + c * wheel["sin_alpha"] * s * h_0) ** 2 + (e_h + c * c * wheel["sin_alpha"] * h_0) ** 2
    roller = h_0**2 * wheel["axial_mobility"]
    return 2.0 / machine["mass"] + spin * wheel["spin_mobility"] + yaw / machine["yaw_inertia"] + roller


def sectors(rollers: np.ndarray) -> np.ndarray:
    """Cosine and sine of 2 pi i / N_r, (W, N, 2)."""
    angle = 2.0 * np.pi * np.arange(rollers.max()) / rollers[:, None]
    sector = np.empty((*angle.shape, 2))
    sector[..., 0], sector[..., 1] = np.cos(angle), np.sin(angle)
    return sector


def merge_tables(config: Config, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All tables of a scene on the union of their knots: starts (S,) and inputs (S, channels, 2).

    Between two knots every input is linear, so one number, the current piece, tells all of them; a jump is two
    equal knots, between which no piece lies. rows: of the ideal machine.
    """
    merged = list(tables(config, rows))
    knots = sorted({time for _, times, _ in merged for time in times if time > 0.0})
    edges = np.array([0.0, *knots, math.inf])
    lasting = edges[1:] - edges[:-1] > SHORTEST * (1.0 + edges[:-1])  # knots that rounding cannot part are a jump
    starts = edges[:-1][lasting]
    inputs = np.zeros((len(starts), DRIVE + len(config.wheels), 2))
    for channels, times, values in merged:
        if len(times) == 1:
            inputs[:, channels, 0] = values
        else:
            inputs[:, channels, 0], inputs[:, channels, 1] = lines(np.array(times), np.array(values), starts)
    starts[0] = 0.0
    return starts, inputs


def tables(config: Config, rows: np.ndarray) -> Iterator[tuple[list[int], Sequence[float], Sequence[Sequence[float]]]]:
    """Channels, times and the values of these channels (K, C) of every table."""
    times, forces, yaw_torques = config.wrench.table
    yield WRENCH, times, [(*force, torque) for force, torque in zip(forces, yaw_torques, strict=True)]
    drives = [wheel.drive for wheel in config.wheels]
    if followers := [w for w, drive in enumerate(drives) if drive.follows_command]:
        twists = np.array(config.command.twist)
        rates = [[rows[w] @ twist for w in followers] for twist in twists]  # of an ideal machine
        yield [DRIVE + w for w in followers], config.command.times, rates
    for w, drive in enumerate(drives):
        if not drive.follows_command:
            times, values = drive.table
            yield [DRIVE + w], times, [[value] for value in values]


def lines(times: np.ndarray, values: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of a table (K, C) at each of `starts` and slopes from there to its next knot (S, C); held outside."""
    after = times.searchsorted(starts, side="right")  # first knot beyond each start
    last, first = np.maximum(after - 1, 0), np.minimum(after, len(times) - 1)
    rise, length = values[first] - values[last], (times[first] - times[last])[:, None]
    slopes = np.divide(rise, length, out=np.zeros(rise.shape), where=length > 0.0)
    return values[last] + slopes * (starts - times[last])[:, None], slopes
