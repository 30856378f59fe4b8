"""What a scene says that is hardly meant: the number, and what is expected instead. Never an error.

Each check yields a Problem for what it doubts; CHECKS is the table of them. Bounds are wide: no machine that can be
built is doubted, and a wheel without a chassis may be in units of its own.
"""

import math
from collections.abc import Callable, Iterator
from itertools import combinations

import numpy as np

from omnisim.scene import machine_rules
from omnisim.scene.drive_schema import Drive
from omnisim.scene.drives import friction_torque, standstill_torque
from omnisim.scene.floor_rules import hollow_ground
from omnisim.scene.ideal_kinematics import MOTIONS, handedness, rms_distance, undetermined, wheel_rows
from omnisim.scene.masses import wheel_mass
from omnisim.scene.problems import Problem
from omnisim.scene.rollers import gap_between_rows, half_length, half_width, hub_radius, roller_solid, thickest
from omnisim.scene.schema import Config, Wheel
from omnisim.scene.solids import disk_solid, gap, outline, pitches
from omnisim.scene.spatial_doubts import fast_rubber, high_start, soft_rubber, soft_springs, wrong_radius
from omnisim.scene.toml_text import KeyPath
from omnisim.scene.wheel_schema import WheelType

ONE_ROW_DEG = 20.0  # roller angle from which on all rollers of a wheel stand in one row; below, in two
ROUNDING = 1e-6  # of the wheel radius: overlaps below are no overlaps
DENSITIES = 50.0, 23000.0  # kg/m^3: foam, and beyond osmium
CHASSIS_DENSITIES = 5.0, 23000.0  # kg/m^3, of a box that may be mostly air
LARGEST_WHEEL = 2.0  # m, radius
FAR = 100.0  # wheel radii from the origin, or of a chassis
WIDE = 10.0  # wheel radii of a width
FASTEST, HEAVIEST_GRAVITY = 50.0, 100.0  # m/s, m/s^2
GYRATION = 0.1, 3.0  # radius of gyration / that of the body
CHASSIS_GYRATION = 0.05, 3.0  # radius of gyration / farthest wheel, or half the diagonal of the box
SHARED = 0.01  # of the smaller wheel's radius: wheels that overlap by less may touch
HALVINGS = 30  # of a distance that just fits: to 1e-9 of it
SLOWEST = 0.01  # m/s^2, of drives at their limits
METRES = "lengths are in metres, not millimetres"


def doubts(config: Config) -> list[Problem]:
    """Everything that is doubtful in a validated scene; a length in a wrong unit alone, since it makes the rest so."""
    return list(large_lengths(config)) or [doubt for check in CHECKS for doubt in check(config)]


# --- rollers on their wheel -----------------------------------------------------------------------


def crowded_rollers(config: Config) -> Iterator[Problem]:
    """Rollers that overlap: the neighbour in a row, the next but one where one row stands for two; those of another
    row."""
    for name, kind in config.wheel_types.items():
        if kind.profile.kind != "exact" or hub_radius(kind) <= 0.0:  # an error; crowded_hub says what is wrong
            continue
        in_two = len(kind.rows) == 1 and abs(kind.roller_angle_deg) < ONE_ROW_DEG
        apart = 2.0 if in_two else pitches(kind, 360.0 / kind.roller_count)
        overlap = -gap(outline(kind), apart)
        if overlap > ROUNDING * kind.radius:
            whom = "the next but one, so that not even two rows hold them," if in_two else "their neighbours"
            message = f"rollers overlap {whom} by {overlap:.3g} m; expected {_room(kind, apart)}"
            yield Problem(("wheel_types", name, "roller_count"), message)
        overlap = -gap_between_rows(kind)
        if overlap > ROUNDING * kind.radius:
            message = f"rollers of two rows overlap by {overlap:.3g} m; expected offsets farther apart"
            yield Problem(("wheel_types", name, "rows"), message)


def _room(kind: WheelType, apart: float) -> str:
    """What would make room: fewer rollers, or thinner ones farther out."""

    def fits(count: int, distance: float) -> bool:
        covered = kind.covered * kind.roller_count / count
        shape = outline(kind)._replace(alpha=covered, roller_distance=distance)
        return distance <= kind.radius * math.cos(covered) and gap(shape, apart) >= 0.0

    # so many have pointed tips; fewer have none
    pointed = kind.covered * kind.roller_count / math.acos(kind.roller_distance / kind.radius)
    ways = []
    fewest = max(3, math.ceil(pointed))
    most = kind.roller_count
    if fits(fewest, kind.roller_distance):
        while most - fewest > 1:
            middle = (fewest + most) // 2
            fewest, most = (middle, most) if fits(middle, kind.roller_distance) else (fewest, middle)
        ways.append(f"at most {fewest} rollers at this distance")
    near = kind.roller_distance
    far = kind.radius * math.cos(kind.covered)
    if fits(kind.roller_count, far):
        for _ in range(HALVINGS):
            between = 0.5 * (near + far)
            near, far = (near, between) if fits(kind.roller_count, between) else (between, far)
        ways.append(f"a roller_distance of at least {far:.4g} m")
    return " or ".join(ways) or "fewer and thinner rollers"


def crowded_hub(config: Config) -> Iterator[Problem]:
    """Rollers that reach into the hub, or to the axle."""
    for name, kind in config.wheel_types.items():
        free = hub_radius(kind)
        hub = kind.disk.hub_radius
        if free <= 0.0:
            message = f"rollers reach the axle; expected more than half the radius, {0.5 * kind.radius:.4g} m"
            yield Problem(("wheel_types", name, "roller_distance"), message)
        elif hub > free * (1.0 + ROUNDING):
            what = f"rollers reach {hub - free:.3g} m into the hub"
            of = "2 roller_distance - radius" if kind.profile.kind == "exact" else "roller_distance - that of a roller"
            message = f"{what}; expected at most {of} = {free:.4g} m"
            yield Problem(("wheel_types", name, "disk", "hub_radius"), message)


# --- sizes and masses -----------------------------------------------------------------------------


def densities(config: Config) -> Iterator[Problem]:
    """Masses that no material makes of the volume of a roller, a disk (that of its whole wheel, at most), a chassis."""
    foam, osmium = DENSITIES if config.chassis else (0.0, DENSITIES[1])
    for name, kind in config.wheel_types.items():
        path = ("wheel_types", name)
        disk = kind.disk
        volume = roller_solid(kind).volume
        key = "mass" if "mass" in kind.roller.model_fields_set else "density"
        yield from _density((*path, "roller", key), kind.roller.mass, volume, "the profile", (foam, osmium))
        if disk.hub_radius and disk.width:
            volume = disk_solid(disk).volume
            what = "hub and plates" if disk.plate_radius else "the hub"
            yield from _density((*path, "disk", "mass"), disk.mass, volume, what, (foam, osmium))
        else:
            volume = 2.0 * math.pi * kind.radius**2 * half_width(kind)
            yield from _density((*path, "disk", "mass"), disk.mass, volume, "the whole wheel", (0.0, osmium))
    if config.chassis and "size" in config.chassis.model_fields_set:
        volume = math.prod(config.chassis.size)
        yield from _density(("chassis", "mass"), config.chassis.mass, volume, "its box", CHASSIS_DENSITIES)


def _density(path: KeyPath, mass: float, volume: float, of: str, bounds: tuple[float, float]) -> Iterator[Problem]:
    low, high = bounds
    if not low <= mass / volume <= high:
        what = f"{mass:.4g} kg in the volume of {of}, {volume * 1e6:.4g} cm^3, is {mass / volume:.3g} kg/m^3"
        yield Problem(path, f"{what}; expected {f'{low:g} to' if low > 0.0 else 'at most'} {high:g}")


def large_lengths(config: Config) -> Iterator[Problem]:
    """Numbers that a machine in metres, metres per second and metres per second squared hardly has."""
    for path, value, limit, unit in _lengths(config):
        if value > limit:
            what = f"{value:.4g} {unit}; expected at most {limit:.3g} {unit}"
            yield Problem(path, f"{what}: {METRES}")


def _lengths(config: Config) -> Iterator[tuple[KeyPath, float, float, str]]:
    """Key, value, the most that is expected, unit."""
    kinds = [config.type_of(wheel) for wheel in config.wheels]
    largest = max(kind.radius for kind in kinds)
    thinnest = min(kind.radius - kind.roller_distance for kind in kinds)
    for name, kind in config.wheel_types.items():
        yield ("wheel_types", name, "radius"), kind.radius, LARGEST_WHEEL, "m"
        yield ("wheel_types", name, "disk", "width"), kind.disk.width, WIDE * kind.radius, "m"
        yield ("wheel_types", name, "roller", "rolling_resistance"), kind.roller.rolling_resistance, thinnest, "m"
    for index, (wheel, kind) in enumerate(zip(config.wheels, kinds, strict=True)):
        yield ("wheels", index, "position"), math.hypot(*wheel.position), FAR * kind.radius, "m"
    if config.chassis:
        yield ("chassis", "center_of_mass"), math.hypot(*config.chassis.center_of_mass), FAR * largest, "m"
        yield ("chassis", "size"), max(config.chassis.size), 2.0 * FAR * largest, "m"
        yield ("chassis", "ground_clearance"), config.chassis.ground_clearance, FAR * largest, "m"
    if config.friction.contact_torque != "none":
        yield ("friction", "patch_radius"), config.friction.patch_radius, thinnest, "m"
    if config.command:
        speeds = [math.hypot(*twist[:2]) for twist in config.command.twist]
        yield ("command", "twist", int(np.argmax(speeds))), max(speeds), FASTEST, "m/s"
    yield ("initial", "velocity"), math.hypot(*config.initial.velocity), FASTEST, "m/s"
    yield ("scene", "gravity"), config.world.gravity, HEAVIEST_GRAVITY, "m/s^2"


def gyrations(config: Config) -> Iterator[Problem]:
    """Inertias far from those of any body of that mass and size, where the mass can be believed."""
    massive = {doubt.path[:-1] for doubt in densities(config)}
    for name, kind in config.wheel_types.items():
        path = ("wheel_types", name)
        roller = kind.roller
        disk = kind.disk
        thick, half = thickest(kind), half_length(kind)
        wide = 0.5 * disk.width or half_width(kind)
        for part, key, mass, size in (
            ("roller", "inertia_axial", roller.mass, thick),
            ("roller", "inertia_transverse", roller.mass, math.hypot(thick, half)),
            ("disk", "inertia_axle", disk.mass, disk.hub_radius or kind.radius),
            ("disk", "inertia_diameter", disk.mass, math.hypot(disk.hub_radius or kind.radius, wide)),
        ):
            if (*path, part) not in massive:
                yield from _gyration((*path, part, key), getattr(getattr(kind, part), key), mass, size, GYRATION)
        if disk.inertia_diameter < 0.5 * disk.inertia_axle * (1.0 - ROUNDING):
            message = f"less than half of inertia_axle, {0.5 * disk.inertia_axle:.4g}; expected at least that: no disk"
            yield Problem((*path, "disk", "inertia_diameter"), f"{message} has less about its diameters")
    if config.chassis and ("chassis",) not in massive:
        size = max(0.5 * math.hypot(*config.chassis.size), *(math.hypot(*wheel.position) for wheel in config.wheels))
        largest = max(config.chassis.inertia)
        place = ("chassis", "inertia", config.chassis.inertia.index(largest))
        if size > 0.0:
            yield from _gyration(place, largest, config.chassis.mass, size, CHASSIS_GYRATION)


def _gyration(
    path: KeyPath, inertia: float, mass: float, size: float, bounds: tuple[float, float]
) -> Iterator[Problem]:
    radius = math.sqrt(inertia / mass)
    low, high = bounds
    if not low * size <= radius <= high * size:
        limits = f"{mass * (low * size) ** 2:.3g} to {mass * (high * size) ** 2:.3g} kg m^2"
        what = f"its radius of gyration is {radius:.3g} m, of a body that reaches {size:.3g} m"
        yield Problem(path, f"{what}; expected {limits} for {mass:.4g} kg")


# --- the machine ----------------------------------------------------------------------------------


def wheels_in_one_place(config: Config) -> Iterator[Problem]:
    """Wheels that take the same room: rectangles of them, seen from above at the height of the lower centre."""
    for (_, first), (index, second) in combinations(enumerate(config.wheels), 2):
        kinds = config.type_of(first), config.type_of(second)
        low = min(kind.radius for kind in kinds)
        overlap = _overlap(_rectangle(first, kinds[0], low), _rectangle(second, kinds[1], low))
        if overlap > SHARED * low:
            apart = math.dist(first.position, second.position)
            what = f"{apart:.3g} m from '{first.name}': the two wheels overlap by {overlap:.3g} m"
            yield Problem(("wheels", index, "position"), f"{what}; expected a place of its own")


def _rectangle(wheel: Wheel, kind: WheelType, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Centre, and the half sides as rows (heading, axle), m: as long as rollers' axes reach at this height."""
    heading = math.radians(wheel.heading_deg)
    chord = math.sqrt(kind.radius**2 - (kind.radius - height) ** 2)
    along = chord * kind.roller_distance / kind.radius
    across = half_width(kind)
    h = np.array([math.cos(heading), math.sin(heading)])
    return np.array(wheel.position), np.array([along * h, across * np.array([-h[1], h[0]])])


def _overlap(a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]) -> float:
    """How far two rectangles would have to be moved apart, m; below 0 if they are apart (separating axes)."""
    sides = np.concatenate([a[1], b[1]])
    axes = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    return float((np.abs(axes @ sides.T).sum(axis=1) - np.abs(axes @ (a[0] - b[0]))).min())


def wrong_hands(config: Config) -> Iterator[Problem]:
    """Mecanum wheels with X for O, and other machines whose spin rates say nothing of their yaw."""
    if config.chassis is None or len(config.wheels) < 3:
        return
    if hands := handedness(config):
        index = next(index for index, wheel in enumerate(config.wheels) if wheel.name in hands.wrong)
        yield Problem(("wheels", index, "mirrored"), f"{hands.told}; expected {hands.cure}")
    elif "rotation" in undetermined(wheel_rows(config), rms_distance(config)):
        what = "no spin rate changes with the yaw rate, so that the machine cannot turn"
        yield Problem(("wheels",), f"{what}; expected headings or roller angles that differ")


def contradicting_angles(config: Config) -> Iterator[Problem]:
    """More wheels that follow angles than the machine has motions, each of which may hold the floor."""
    following = [index for index, wheel in enumerate(config.wheels) if wheel.drive.kind == "follow"]
    if config.friction.law == "coulomb" and len(following) > len(MOTIONS):
        what = f"{len(following)} wheels follow angles, and more than three may contradict each other"
        message = f"{what}, but this law lets all hold the floor; expected one that always slips, as regularized does"
        yield Problem(("friction", "law"), message)


def beyond_the_wheels(config: Config) -> Iterator[Problem]:
    """Where contacts carry a machine this is an error; a servo holds it, which no floor does."""
    if config.chassis and config.upright == "servo" and (outside := machine_rules.outside(config)):
        message = f"{outside}; expected between the wheels: only the servo keeps the machine from tipping"
        yield Problem(("chassis", "center_of_mass"), message)


# --- drives ---------------------------------------------------------------------------------------


def weak_motors(config: Config) -> Iterator[Problem]:
    """A motor that its own friction holds."""
    for index, wheel in enumerate(config.wheels):
        drive = wheel.drive
        most = most_torque(wheel.drive)
        friction = friction_torque(drive)
        if 0.0 < most <= friction:
            message = f"at most {most:.3g} N m at the wheel, where friction of {friction:.3g} N m holds it"
            yield Problem(("wheels", index, "drive", _strength(drive)), f"{message}; expected more than that")


def weak_drives(config: Config) -> Iterator[Problem]:
    """Drives that all together, at their limits, cannot move their own machine, or hardly.

    By powers of the ideal machine in each of its motions: of drives sum T |phi'|, of friction in motors and in bearings
    of rollers sum T_f |phi'| + T_b |chi'|, chi' = V_k / ((R - R1) cos psi).
    """
    wheels = config.wheels
    kinds = [config.type_of(wheel) for wheel in config.wheels]
    torques = np.array([most_torque(wheel.drive) for wheel in wheels])
    if config.chassis is None or not np.isfinite(torques).all() or not torques.any():
        return
    mass = config.chassis.mass + sum(map(wheel_mass, kinds))
    spins = np.abs(wheel_rows(config))
    first = int(np.argmax(torques > 0.0))
    spins[spins < ROUNDING * spins.max()] = 0.0
    pushes = torques @ spins
    drags = np.array([friction_torque(wheel.drive) for wheel in wheels]) @ spins
    drags += sum(_bearing_drag(wheel, kind) for wheel, kind in zip(wheels, kinds, strict=True))
    for name, unit, push, drag in zip(MOTIONS, ("N", "N", "N m"), pushes, drags, strict=True):
        what = f"in {name} all drives at their limits give {push:.3g} {unit}, of which friction takes {drag:.3g} {unit}"
        doubt = ""
        if 0.0 < push <= drag:
            doubt = f"{what}, so that the machine cannot move; expected more than that"
        elif unit == "N" and 0.0 < push < (need := drag + SLOWEST * mass):
            doubt = f"{what}; expected at least {need:.3g} N, for {SLOWEST:g} m/s^2 of {mass:.4g} kg"
        if doubt:
            yield Problem(("wheels", first, "drive", _strength(wheels[first].drive)), doubt)
            return


def _bearing_drag(wheel: Wheel, kind: WheelType) -> np.ndarray:
    """What the bearing of the roller in contact takes in the unit motions of the chassis, N, N, N m."""
    heading = math.radians(wheel.heading_deg)
    x, y = wheel.position
    sin, cos = math.sin(heading), math.cos(heading)
    lever = (kind.radius - kind.roller_distance) * math.cos(math.radians(kind.roller_angle_deg))  # V_k / chi'
    return kind.roller.bearing_torque * np.abs([-sin, cos, y * sin + x * cos]) / lever


def most_torque(drive: Drive) -> float:
    """Of a drive at its limit and a standing wheel, N m, without what its friction takes.

    0 where nothing drives, inf where nothing limits it or a scene gives the torque itself; a motor at 0 V waits for
    a controller from outside.
    """
    waits = drive.kind == "dc_motor" and not drive.controlled and not any(drive.table[1])
    return math.inf if waits or drive.kind == "torque" else standstill_torque(drive)


def _strength(drive: Drive) -> str:
    if drive.controlled:
        return "torque_limit" if drive.kind == "rate" else "kind"
    return "voltage"


Check = Callable[[Config], Iterator[Problem]]
CHECKS: tuple[Check, ...] = (
    hollow_ground,
    crowded_rollers,
    crowded_hub,
    wrong_radius,
    large_lengths,
    densities,
    gyrations,
    wheels_in_one_place,
    wrong_hands,
    contradicting_angles,
    beyond_the_wheels,
    weak_motors,
    weak_drives,
    soft_rubber,
    soft_springs,
    fast_rubber,
    high_start,
)
