"""From a scene to the numbers that kernels know: `pack` is the only place where that happens."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from omnisim.base.keeping import kept
from omnisim.base.records import blank, records
from omnisim.base.trigonometry import exact_cos_sin
from omnisim.contact.friction import LAWS
from omnisim.contact.mobility import HEAVY
from omnisim.dynamics.inertia import central_inertia
from omnisim.dynamics.input_tables import merge_tables
from omnisim.dynamics.parameters import (
    ARTICULATED,
    CONTACT,
    CONTACTS,
    FREE,
    JOINT,
    LOADS,
    MACHINE,
    PART,
    RESTING,
    ROLLER_ROW,
    SERVO,
    Parameters,
    Workspace,
)
from omnisim.dynamics.spatial.packing import carried_wheels, mobility_bound, pack_space
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.state import TOUCHING, Contents, Places, places_in_space, places_of
from omnisim.dynamics.wheel_values import (
    bearing_relaxation,
    placed_values,
    shared_values,
    slip_mobility_bound,
    wheel_records,
)
from omnisim.scene.drives import DriveLaw, drive_law
from omnisim.scene.ground_schema import Floor
from omnisim.scene.ideal_kinematics import inverse, rms_distance, wheel_rows
from omnisim.scene.masses import common_centre, exact_moments, point_masses
from omnisim.scene.schema import Config, Friction, World, Wrench
from omnisim.scene.wheel_schema import WheelType

UPRIGHT = {"servo": SERVO, "contacts": CONTACTS, "free": FREE}


def pack(config: Config) -> Parameters:
    """Parameters of a validated scene.

    What follows from one table of the scene, or from a few, is kept: of a machine that differs from one before in some
    of its tables only what follows from those is found anew.
    """
    types = [config.type_of(wheel) for wheel in config.wheels]
    laws = [drive_law(wheel.drive) for wheel in config.wheels]
    rows = wheel_rows(config)
    machine = machine_values(config, types, laws)
    centre, step = machine["centre"].tolist(), config.time.step
    shared = [
        shared_values(kind, law, wheel.mirrored, step)
        for kind, wheel, law in zip(types, config.wheels, laws, strict=True)
    ]
    wheels = [
        own | placed_values(kind, wheel, centre) for own, kind, wheel in zip(shared, types, config.wheels, strict=True)
    ]
    twists = None if config.chassis is None else inverse(rows, rms_distance(config))
    machine["odometry"] = twists is not None
    if twists is not None:
        spin_angles = np.array([wheel.spin_angle for wheel in config.wheels])
        for wheel, column in zip(wheels, twists.T.tolist(), strict=True):
            wheel["odometry"] = column
        machine["odometry_yaw"] = math.radians(config.initial.yaw_deg) - twists[2] @ spin_angles
    machine["places"] = state_places(config, machine)
    for wheel in wheels:
        heavy = 1.0 / (HEAVY * machine["mass"] * wheel["radius"] ** 2)
        wheel["holding_mobility"] = heavy if wheel["follows"] else wheel["spin_mobility"]
    space = pack_space(config, wheels, machine) if config.upright == "free" else None
    if space is None:
        bounds = [slip_mobility_bound(machine, wheel, kind) for wheel, kind in zip(wheels, types, strict=True)]
    else:
        bounds = [mobility_bound(space, wheel) for wheel in wheels]
    machine["slip_mobility"] = max(bounds)
    constants = (
        records(MACHINE, [machine])[0],
        wheel_records(wheels, shared, types, machine),
        rows_of(wheels, types),
        sectors(*(kind.rollers for kind in types)).copy(),
    )
    return Parameters(*constants, *merge_tables(config, rows), workspace(config, len(wheels), machine["most"]), space)


def state_places(config: Config, machine: dict) -> Places:
    """Where everything stands in the state."""
    wheels, free = len(config.wheels), config.upright == "free"
    flags = "integrals", "currents", "bearing_friction", "rolling", "motors", "odometry"
    contents = Contents(
        wheels,
        machine["slots"],
        **{flag: int(machine[flag]) for flag in flags},
        rhos=wheels * machine["most"] if config.solver.tracking == "implicit" else 0,
        bodies=1 + wheels * (1 + machine["most"]) if config.solver.formulation == "multibody" else 0,
        carriers=len(carried_wheels(config)) if free else 0,
    )
    return (places_in_space if free else places_of)(contents)


def workspace(config: Config, wheels: int, rollers: int) -> Workspace:
    """A Workspace for a scene of so many wheels, of at most so many rollers."""
    parts = blank(PART, wheels)
    parts["first"] = [TOUCHING * w for w in range(wheels)]
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
    """Values of the MACHINE record, but those that take all wheels to know; and `most`: rollers of a wheel."""
    friction, chassis = config.friction, config.chassis
    whole = bodies(config)
    along, normal = gravity(config)
    at_centre = np.array([0.0, 0.0, whole.centre[2]])  # of a bare wheel
    pushed = at_centre if chassis is None else np.array(chassis.center_of_mass)
    rollers = roller_flags(*types)
    every_rate = rollers["bearing_friction"] or config.solver.formulation == "multibody"
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
        "chassis_mass": chassis.mass if chassis else 0.0,
        "chassis_inertia": chassis.inertia if chassis else (0.0, 0.0, 0.0),
        "every_rate": every_rate,
        "slots": rollers["most"] if every_rate else SLOTS if config.upright == "free" else TOUCHING,
        "odometry_yaw": 0.0,
        **rollers,
        **drive_flags(*laws),
        **push_flags(config.wrench),
    }


@kept
def roller_flags(*types: WheelType) -> dict:
    """Those that tell of the rollers of all wheels."""
    return {
        "most": max(kind.rollers for kind in types),
        "bearing_friction": any(kind.roller.has_bearing_friction for kind in types),
        "rolling": any(kind.roller.has_rolling_resistance for kind in types),
        "bearing_relaxation": max(bearing_relaxation(kind.roller) for kind in types),
    }


@kept
def drive_flags(*laws: DriveLaw) -> dict:
    """Those that tell of all drives."""
    motors = [law.motor for law in laws if law.motor]
    return {
        "integrals": any(law.integrates for law in laws),
        "motors": bool(motors),
        "currents": any(motor.inductance > 0.0 for motor in motors),
        "current_relaxation": max((m.resistance / m.inductance for m in motors if m.inductance > 0.0), default=0.0),
        "follows": any(law.follows for law in laws),
        "sampled": any(law.sample_time > 0.0 for law in laws),
    }


@kept
def push_flags(wrench: Wrench) -> dict:
    """Those that tell of the wrench."""
    return {
        "pushed": any(any(force) or torque for force, torque in zip(*wrench.table[1:], strict=True)),
        "body_frame": wrench.frame == "body",
    }


def gravity(config: Config) -> tuple[tuple[float, float], float]:
    """What of gravity lies along the floor, world x and y, and what is normal to it, downwards; m/s^2."""
    return parted_gravity(config.world, config.floor)


@kept
def parted_gravity(world: World, floor: Floor) -> tuple[tuple[float, float], float]:
    """The same of these tables."""
    slope = math.radians(floor.slope_deg)
    size = world.gravity
    cos, sin = exact_cos_sin(floor.uphill_deg)
    downhill = size * math.sin(slope)
    return (-downhill * cos + 0.0, -downhill * sin + 0.0), size * math.cos(slope)


def slip_floor(friction: Friction, weight: float) -> float:
    """Slip over which friction changes near zero slip, m/s: of viscous friction that at which it carries the weight."""
    if friction.law == "viscous" and friction.viscosity > 0.0:
        return weight / friction.viscosity
    if friction.law == "brush":
        return friction.coefficient / friction.creep_stiffness * friction.slip_speed
    return {"coulomb": 0.0, "regularized": friction.slip_speed, "saturated": friction.slip_speed}.get(friction.law, 1.0)


def rows_of(wheels: list[dict], types: list[WheelType]) -> np.recarray:
    """The rows of rollers of wheels with these values, records ROLLER_ROW."""
    rows = blank(ROLLER_ROW, sum(len(kind.rings) for kind in types))
    rows["phase"] = [wheel["phase"] for wheel, kind in zip(wheels, types, strict=True) for _ in kind.rings]
    rows["offset"] = [row.offset for kind in types for row in kind.rings]
    return rows


@lru_cache
def sectors(*rollers: int) -> np.ndarray:
    """Cosine and sine of 2 pi i / N_r, (W, N, 2)."""
    angle = 2.0 * np.pi * np.arange(max(rollers)) / np.array(rollers)[:, None]
    sector = np.empty((*angle.shape, 2))
    sector[..., 0], sector[..., 1] = np.cos(angle), np.sin(angle)
    return sector
