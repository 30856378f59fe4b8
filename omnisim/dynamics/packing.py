"""From a scene to the numbers that kernels know: `pack` is the only place where that happens."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from omnisim.base.blocks import cleared
from omnisim.base.keeping import Ask, alone, kept
from omnisim.base.records import records, single
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
    PLAIN,
    RESTING,
    ROLLER_ROW,
    SELDOM,
    SERVO,
    Parameters,
    Workspace,
)
from omnisim.dynamics.spatial.packing import carried_wheels, mobility_bound, pack_space
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.state import TOUCHING, Contents, Places, places_in_space, places_of
from omnisim.dynamics.wheel_values import (
    HEADING,
    OWN,
    Reach,
    bearing_relaxation,
    heading_values,
    placed_values,
    reach,
    shared_records,
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

# A layer of slip is thin if friction would take a whole machine through it so many times within a step, and it is no
# thicker than this (m/s) and than the error that is asked for: a hundredth of it is not told, or up to a tenth.
THIN, THICKEST = 10.0, 1e-6


def pack(config: Config, ask: Ask[Config] = alone) -> Parameters:
    """Parameters of a validated scene.

    What follows from one table of the scene, or from a few, is kept: of a machine that differs from one before in some
    of its tables only what follows from those is found anew. ask: who tells what follows from the scene; of variants
    their Common, so that they share arrays.
    """
    machine = ask(machine_kind, config) | machine_values(config, ask)
    centre = machine["centre"]
    shared, headings = ask(shared_of, config), ask(headings_of, config)
    mounted = zip(ask(types_of, config), config.wheels, headings, strict=True)
    placed = [placed_values(kind, wheel, heading, centre) for kind, wheel, heading in mounted]
    for wheel, own in zip(placed, shared, strict=True):
        heavy = 1.0 / (HEAVY * machine["mass"] * own["radius"] ** 2)
        wheel["holding_mobility"] = heavy if own["follows"] else own["spin_mobility"]
    space = None
    if machine["upright"] == FREE:
        wheels = [own | heading | place for own, heading, place in zip(shared, headings, placed, strict=True)]
        space = pack_space(config, wheels, machine)
        bounds = [mobility_bound(space, wheel) for wheel in wheels]
    else:
        offsets = [wheel["offset"] for wheel in placed]
        reaches = zip(offsets, ask(reaches_of, config), strict=True)
        bounds = [slip_mobility_bound(machine, offset, found) for offset, found in reaches]
    machine["slip_mobility"] = max(bounds)
    kind = MACHINE if any(machine[name] for name in SELDOM) else PLAIN
    return Parameters(
        single(kind, records(kind, [machine])),
        wheel_records(ask(wheel_bytes, config), OWN, placed),
        rows_of(ask(offsets_of, config), placed),
        ask(sectors_of, config),
        *ask(merge_tables, config),
        blank_workspace(config, machine["most"]),
        space,
    )


# --- of a scene -----------------------------------------------------------------------------------


@kept
def types_of(config: Config) -> list[WheelType]:
    """Of all wheels."""
    return [config.type_of(wheel) for wheel in config.wheels]


@kept
def shared_of(config: Config) -> list[dict]:
    """Those values of the WHEEL record of each wheel that others share."""
    step = config.time.step
    return [
        shared_values(kind, drive_law(wheel.drive), wheel.mirrored, step)
        for kind, wheel in zip(types_of(config), config.wheels, strict=True)
    ]


@kept
def headings_of(config: Config) -> list[dict]:
    """Values of the WHEEL record of each wheel that tell where it heads."""
    found = list(map(heading_values, config.wheels))
    twists = odometry_of(config)
    if twists is not None:
        for values, column in zip(found, twists.T.tolist(), strict=True):
            values["odometry"] = column
    return found


@kept
def odometry_of(config: Config) -> np.ndarray | None:
    """(3, W): the twist of the chassis by the spin rates of ideal wheels; None if they leave a motion open."""
    return None if config.chassis is None else inverse(wheel_rows(config), rms_distance(config))


def reaches_of(config: Config) -> list[Reach]:
    return [reach(*each) for each in zip(shared_of(config), types_of(config), strict=True)]


def wheel_bytes(config: Config) -> bytes:
    """Of the records WHEEL, but what is their OWN."""
    machine = machine_kind(config)
    shared = shared_records(machine["slots"], machine["places"], *shared_of(config), *types_of(config))
    return wheel_records(shared, HEADING, headings_of(config)).tobytes()


def blank_workspace(config: Config, most: int) -> Workspace:
    """A Workspace for this scene, whose wheels have at most so many rollers."""
    wheels, multibody = len(config.wheels), config.solver.formulation == "multibody"
    contacts, parts, loads, resting, articulated, joints = cleared(
        (CONTACT, (TOUCHING * wheels,)),
        (PART, (wheels,)),
        (LOADS, (1,)),
        (RESTING, (TOUCHING,)),
        (ARTICULATED, (wheels,)),
        (JOINT, (wheels, most + 1)),
    )
    parts["first"] = [TOUCHING * w for w in range(wheels)]
    coulomb = config.friction.law == "coulomb" or thin_layer(config)
    return Workspace(
        contacts,
        parts,
        single(LOADS, loads),
        resting if coulomb else None,
        articulated if multibody else None,
        joints if multibody else None,
        np.zeros((2, 3, most)),
    )


class Bodies(NamedTuple):
    """What the bodies of a machine make up: M, the common centre of mass (x, y, z), I_z and S about it, SI."""

    mass: float
    centre: np.ndarray
    yaw_inertia: float
    moment: np.ndarray


def bodies(config: Config, ask: Ask[Config] = alone) -> Bodies:
    """The chassis, and each wheel with its rollers as one body; chassis axes."""
    masses, points = point_masses(config)
    inertias = ask(wheel_inertias, config)
    if config.chassis is not None:
        inertias = [*inertias, config.chassis.inertia[2]]
    x_centre, y_centre, height = common_centre(masses, points)
    planar = [(x - x_centre, y - y_centre) for x, y, _ in points]
    yaw_inertia = math.fsum(inertias) + math.fsum(m * (x * x + y * y) for m, (x, y) in zip(masses, planar, strict=True))
    lifted = [m * z for m, (_, _, z) in zip(masses, points, strict=True)]
    moment = np.array(exact_moments(lifted, planar))
    return Bodies(math.fsum(masses), np.array([x_centre, y_centre, height]), yaw_inertia, moment)


def wheel_inertias(config: Config) -> list[float]:
    """Of each wheel with its rollers about the diameter through its centre of mass, kg m^2."""
    return [central_inertia(kind) for kind in types_of(config)]


def machine_values(config: Config, ask: Ask[Config]) -> dict:
    """Values of the MACHINE record that tell how large everything is, but the bound of its mobility."""
    chassis, whole = config.chassis, bodies(config, ask)
    along, normal = ask(gravity, config)
    centre = whole.centre.tolist()
    pushed = (0.0, 0.0, centre[2]) if chassis is None else chassis.center_of_mass  # of a bare wheel its centre
    friction = ask(friction_values, config)
    return {
        "gravity": normal,
        "downhill": along,
        "mass": whole.mass,
        "mobility": 1.0 / whole.mass,
        "yaw_inertia": whole.yaw_inertia,
        "yaw_mobility": 1.0 / whole.yaw_inertia,
        "height": centre[2],
        "moment": whole.moment.tolist(),
        "centre": centre[:2],
        "lever": [to - origin for to, origin in zip(pushed, centre, strict=True)],
        "slip_floor": 0.0 if thin_layer(config) else slip_floor(config.friction, whole.mass * normal),
        "chassis_mass": chassis.mass if chassis else 0.0,
        "chassis_inertia": chassis.inertia if chassis else (0.0, 0.0, 0.0),
        "odometry_yaw": ask(odometry_yaw, config),
        **friction,
    }


def friction_values(config: Config) -> dict:
    """Those of friction."""
    friction = config.friction
    return {
        "friction": friction.coefficient,
        "slip_speed": friction.slip_speed,
        "slip_layer": friction.slip_speed if thin_layer(config) else 0.0,
        "creep_stiffness": friction.creep_stiffness,
        "viscosity": friction.viscosity,
        "patch_radius": friction.patch_radius if friction.contact_torque != "none" else 0.0,
    }


def odometry_yaw(config: Config) -> float:
    """Yaw that the wheels report at spin angles 0, rad; 0 where they report none."""
    twists = odometry_of(config)
    if twists is None:
        return 0.0
    return float(
        math.radians(config.initial.yaw_deg) - twists[2] @ np.array([wheel.spin_angle for wheel in config.wheels])
    )


@kept
def machine_kind(config: Config) -> dict:
    """Values of the MACHINE record that tell what the machine has, and where that stands in the state."""
    rollers = roller_flags(*types_of(config))
    every_rate = rollers["bearing_friction"] or config.solver.formulation == "multibody"
    found = {
        "inclined": any(gravity(config)[0]),
        "upright": UPRIGHT[config.upright],
        "law": LAWS["coulomb" if thin_layer(config) else config.friction.law],
        "viscous": config.friction.law == "viscous",
        "brush": config.friction.law == "brush",
        "implicit_tracking": config.solver.tracking == "implicit",
        "every_rate": every_rate,
        "slots": rollers["most"] if every_rate else SLOTS if config.upright == "free" else TOUCHING,
        "odometry": odometry_of(config) is not None,
        **rollers,
        **drive_flags(*(drive_law(wheel.drive) for wheel in config.wheels)),
        **push_flags(config.wrench),
    }
    return found | {"places": state_places(config, found)}


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


def thin_layer(config: Config) -> bool:
    """Whether method "auto" takes slip within slip_speed of the saturated law for relaxed: march/thin_layer.py."""
    friction, solver = config.friction, config.solver
    if friction.law != "saturated" or solver.method != "auto" or solver.formulation == "multibody":
        return False
    thickest = THICKEST if solver.error is None else min(solver.error, THICKEST)
    if config.upright == "free" or config.time.step is None or friction.slip_speed > thickest:
        return False
    return friction.coefficient * config.world.gravity * config.time.step > THIN * friction.slip_speed


def slip_floor(friction: Friction, weight: float) -> float:
    """Slip over which friction changes near zero slip, m/s: of viscous friction that at which it carries the weight."""
    if friction.law == "viscous" and friction.viscosity > 0.0:
        return weight / friction.viscosity
    if friction.law == "brush":
        return friction.coefficient / friction.creep_stiffness * friction.slip_speed
    return {"coulomb": 0.0, "regularized": friction.slip_speed, "saturated": friction.slip_speed}.get(friction.law, 1.0)


def offsets_of(config: Config) -> list[tuple[int, float]]:
    """Of each row of rollers its wheel, and how far it is from the middle of that along the axle, m."""
    return [(w, row.offset) for w, kind in enumerate(types_of(config)) for row in kind.rings]


def rows_of(offsets: list[tuple[int, float]], placed: list[dict]) -> np.recarray:
    """Records ROLLER_ROW of the rows with these `offsets_of`, of wheels with these values."""
    return records(ROLLER_ROW, [{"phase": placed[w]["phase"], "offset": offset} for w, offset in offsets])


def sectors_of(config: Config) -> np.ndarray:
    kinds = types_of(config)
    return sectors(*((kind.rollers, tuple(row.offset for row in kind.rings)) for kind in kinds)).copy()


@lru_cache
def sectors(*wheels: tuple[int, tuple[float, ...]]) -> np.ndarray:
    """Cosine and sine of 2 pi i / N_r and the offset of its row, m, (W, 3, N), of wheels by N_r and offsets of rows."""
    number = np.arange(max(rollers for rollers, _ in wheels))
    sector = np.empty((len(wheels), 3, len(number)))
    for found, (rollers, offsets) in zip(sector, wheels, strict=True):
        angle = 2.0 * np.pi * number / rollers
        found[:] = np.cos(angle), np.sin(angle), np.array(offsets)[number % len(offsets)]
    return sector
