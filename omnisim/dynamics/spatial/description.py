"""What is modelled of a machine free in space, and what is left out, each with its reason."""

from collections.abc import Iterator

from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.parts import (
    Part,
    bearing_loads,
    bearing_reason,
    command_reason,
    driven,
    drives,
    friction_reason,
    patch_reason,
    rolling_reason,
    slope_reason,
    wheels_reason,
    wrench_reason,
)
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.state import places_in
from omnisim.scene.generatrix import generatrix
from omnisim.scene.ground_schema import Floor
from omnisim.scene.heights import heights_of
from omnisim.scene.lobes import lobes
from omnisim.scene.masses import chassis_box
from omnisim.scene.schema import Config
from omnisim.scene.wheel_schema import WheelType

NOUNS = {
    "cylinder": "cylinders",
    "capsule": "capsules",
    "sphere": "spheres",
    "cone": "cones, back to back",
    "stepped": "cylinders with steps",
    "points": "a measured generatrix",
}


def parts_in_space(config: Config, parameters: Parameters) -> Iterator[Part]:
    """All parts, modelled or not."""
    yield from _bodies(config, parameters)
    yield from driven(config, parameters)
    yield from _ground(config)
    yield from drives(config.wheels)
    yield Part("command", config.command is not None, 0, command_reason(config))
    yield Part("slope", bool(parameters.machine.inclined), 0, slope_reason(config))
    yield Part("wrench", bool(config.wrench.times), 0, wrench_reason(config))
    yield Part("chassis", True, 0, _chassis_reason(config))
    yield Part("products of inertia", False, 0, "of the chassis: taken as zero")
    yield Part("sideways rubber", False, 0, "rubber gives along the normal alone")
    yield bearing_loads(config)
    torque = config.friction.contact_torque != "none"
    yield Part("contact torque", torque, 0, patch_reason(config.friction))
    yield Part("bearing friction", bool(parameters.machine.bearing_friction), 0, bearing_reason(config))
    yield Part("rolling resistance", bool(parameters.machine.rolling), 0, rolling_reason(config))


def _bodies(config: Config, parameters: Parameters) -> Iterator[Part]:
    """What has states, or would have."""
    machine = parameters.machine
    at = places_in(parameters)
    wheels = len(config.wheels)
    yield Part("rigid body", True, 13, "the chassis in space: position, quaternion, velocity, angular velocity")
    yield Part("spin", True, 2 * wheels, wheels_reason(config))
    springs = sum(wheel.suspension is not None for wheel in config.wheels)
    yield Part("suspensions", springs > 0, 2 * springs, _spring_reason(config))
    rockers = len(config.axles)
    yield Part("rockers", rockers > 0, 2 * rockers, _rocker_reason(config))
    count = at.integral - at.roller_rate
    if machine.every_rate:
        yield Part("roller rates", True, count, "all, since bearings have friction")
    else:
        why = f"rates of those of each wheel that touch, {SLOTS} at most at once; none while it is in the air"
        yield Part("rollers in contact", True, count, why)
        total = sum(config.type_of(wheel).rollers for wheel in config.wheels)
        yield Part("rollers in the air", False, 0, f"the others of {total} keep theirs exactly: frictionless bearings")


def _ground(config: Config) -> Iterator[Part]:
    """Rubber, shapes of rollers, and what they roll on."""
    yield Part("normal forces", True, 0, _by_type(config, _rubber))
    yield Part("profile", True, 0, _by_type(config, _shape))
    yield Part("floor", True, 0, _floor_reason(config.floor))
    yield Part("friction", config.friction.law != "none", 0, friction_reason(config.friction))


def _by_type(config: Config, tell) -> str:
    """What is told of the wheel types in use: once where it is the same of all."""
    told = {name: tell(config.wheel_types[name]) for name in dict.fromkeys(wheel.type for wheel in config.wheels)}
    if len(set(told.values())) == 1:
        return next(iter(told.values()))
    return "; ".join(f"type '{name}': {text}" for name, text in told.items())


def _rubber(kind: WheelType) -> str:
    assert kind.contact is not None
    stiffness, damping = f"k = {kind.contact.stiffness:g} N/m", f"c = {kind.contact.damping:g} N s/m"
    return f"N = max(0, k delta + c delta'): {stiffness}, {damping}; where it begins and ends is an event"


def _shape(kind: WheelType) -> str:
    profile = kind.profile
    rows = f"; {len(kind.rows)} rows" if len(kind.rows) > 1 else ""
    if profile.kind == "exact":
        return f"exact: round while the wheel is upright; touched where it is lowest at any tilt{rows}"
    if profile.kind == "arc":
        return f"barrels, curved along their axes with a radius of {profile.curvature_radius:g} m{rows}"
    count = len(lobes(generatrix(profile)))
    apart = f", {count} convex parts that touch each on its own" if count > 1 else ""
    return f"{NOUNS[profile.kind]}{apart}{rows}"


def _floor_reason(floor: Floor) -> str:
    if floor.is_plane:
        return "a plane"
    bumps, pits = (sum(sign * bump[2] > 0.0 for bump in floor.bumps) for sign in (1.0, -1.0))
    counts = ((bumps, "bump"), (pits, "pit"), (len(floor.steps), "step"))
    found = [f"{count} {what}{'s' * (count > 1)}" for count, what in counts if count]
    if floor.grid is not None:
        rows, columns = heights_of(floor.grid.file).shape
        found.append(f"a grid of {rows} x {columns} heights")
    return f"{', '.join(found)}; touched by common normals"


def _spring_reason(config: Config) -> str:
    having: dict[str, list[str]] = {}
    for wheel in config.wheels:
        if wheel.suspension is not None:
            spring = wheel.suspension
            law = f"{spring.stiffness:g} N/m, {spring.damping:g} N s/m, preload {spring.preload:g} N"
            having.setdefault(law, []).append(wheel.name)
    if not having:
        return "no wheel has one"
    told = (f"{', '.join(names)}: {law}" if len(having) > 1 else law for law, names in having.items())
    return f"hubs slide along chassis z; {'; '.join(told)}"


def _rocker_reason(config: Config) -> str:
    if not config.axles:
        return "the scene has no [[axles]]"
    told = (f"'{axle.name}' ({', '.join(axle.wheels)}) about {axle.about}" for axle in config.axles)
    return f"turn freely: {'; '.join(told)}"


def _chassis_reason(config: Config) -> str:
    chassis = config.chassis
    assert chassis is not None
    inertia = ", ".join(f"{value:g}" for value in chassis.inertia)
    what = "its centre of mass" if chassis_box(config) is None else "its box"
    return f"{chassis.mass:g} kg, inertia [{inertia}] kg m^2; where {what} touches the ground the run stops"
