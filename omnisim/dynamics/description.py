"""What of the physics a scene asks for, and what is left out, each with its reason."""

from collections.abc import Iterator
from typing import NamedTuple

from omnisim.base.formatting import hanging
from omnisim.base.records import plain
from omnisim.dynamics.parameters import CONTACTS, Parameters
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
from omnisim.dynamics.spatial.description import parts_in_space
from omnisim.dynamics.state import places_in
from omnisim.scene.schema import Config, unused_keys
from omnisim.scene.wheel_schema import WheelType


class Model(NamedTuple):
    """The parts of a model; `line` and `text` are what people read."""

    parts: tuple[Part, ...]
    unused: tuple[str, ...]

    @property
    def states(self) -> int:
        return sum(part.states for part in self.parts)

    @property
    def line(self) -> str:
        """One line: the parts with their states, then those that are algebra only."""
        counted = ", ".join(f"{part.name} {part.states}" for part in self.parts if part.states)
        others = ", ".join(part.name for part in self.parts if part.modelled and not part.states)
        return f"{self.states} states ({counted}); {others}"

    @property
    def text(self) -> str:
        """Aligned lines: modelled, left out, keys that this scene does not use."""
        width = max(len(part.name) for part in self.parts)
        lines: dict[bool, list[str]] = {True: [f"modelled: {self.states} states"], False: ["left out:"]}
        for part in self.parts:
            states = (part.states or "-") if part.modelled else ""
            lines[part.modelled].append(hanging(f"  {part.name:<{width}}  {states:>3}  ", part.why))
        unused = [hanging("not used by this scene: ", ", ".join(self.unused))] if self.unused else []
        return "\n".join(lines[True] + lines[False] + unused)


def describe(config: Config, parameters: Parameters) -> Model:
    """The model of a validated scene and its Parameters."""
    parameters = parameters._replace(machine=plain(parameters.machine))
    if parameters.space is not None:
        parts = tuple(parts_in_space(config, parameters))
    else:
        parts = (*integrated(config, parameters), *algebraic(config, parameters))
    return Model(parts, unused_keys(config))


def integrated(config: Config, parameters: Parameters) -> Iterator[Part]:
    """What has states, or would have."""
    machine = parameters.machine
    at = places_in(parameters)
    wheels, _, most = parameters.sector.shape
    bearings = bool(machine.bearing_friction)
    implicit = config.solver.tracking == "implicit"
    multibody = parameters.workspace.articulated is not None
    count = at.integral - at.roller_rate
    every = bearings or multibody
    yield Part("plane motion", True, 6, motion_reason(config))
    yield Part("spin", True, 2 * wheels, wheels_reason(config))
    yield Part("rollers in contact", True, 0 if every else count, contacts_reason(config))
    if every:
        why = "bearings have friction" if bearings else "they are bodies"
        yield Part("roller rates", True, count, f"all, since {why}; {most} states a wheel")
    else:
        yield Part("rollers in the air", False, 0, air_reason(config))
    yield from driven(config, parameters)
    why = "implicit tracking integrates the unit vector of each roller"
    why = why if implicit else "explicit tracking has the contact point in closed form"
    yield Part("rho", implicit, 3 * most * wheels * implicit, why)
    why = "formulation 'multibody' has chassis, disks and rollers in space, and multipliers of joints and floor"
    if not multibody:
        why = "formulation 'reduced' has eliminated the joints; 'multibody' keeps every body, for ten times the time"
    yield Part("rigid bodies", multibody, (at.drift + 2 - at.bodies) * multibody, why)


def algebraic(config: Config, parameters: Parameters) -> Iterator[Part]:
    """What adds no state."""
    chassis = config.chassis
    carried = parameters.machine.upright == CONTACTS
    friction = config.friction
    yield Part("normal forces" if chassis else "normal force", True, 0, load_reason(config, carried))
    yield Part("servo", not carried, 0, servo_reason(config, carried))
    yield Part("friction", friction.law != "none", 0, friction_reason(friction, parameters.machine.slip_layer > 0.0))
    yield from drives(config.wheels)
    if chassis:
        yield Part("command", config.command is not None, 0, command_reason(config))
    yield Part("slope", bool(parameters.machine.inclined), 0, slope_reason(config))
    yield Part("wrench", bool(config.wrench.times), 0, wrench_reason(config))
    yield Part("chassis", chassis is not None, 0, chassis_reason(config))
    if chassis:
        yield Part("other inertia", False, 0, "Ixx, Iyy play no part upright; products are taken as zero")
    takes = (
        "the floor takes them away, which gives the normal forces"
        if carried
        else "the floor and the servo take them away"
    )
    yield Part("heave, roll and pitch", False, 0, takes)
    yield Part("compliance", False, 0, "bodies and floor are rigid: no suspension")
    yield bearing_loads(config)
    yield Part("contact torque", friction.contact_torque != "none", 0, patch_reason(friction))
    yield Part("bearing friction", bool(parameters.machine.bearing_friction), 0, bearing_reason(config))
    yield Part("rolling resistance", bool(parameters.machine.rolling), 0, rolling_reason(config))


def motion_reason(config: Config) -> str:
    if config.chassis:
        return "x, y of the common centre of mass, and yaw; upright on the plane floor"
    return "x, y and yaw of the wheel; the servo holds it upright on the plane floor"


def contacts_reason(config: Config) -> str:
    shape = "exact profile, rigid contact"
    if config.chassis:
        rowed = [kind for kind in config.wheel_types.values() if len(kind.rows) > 1]
        shape += "; the contact goes from row to row" if rowed else ""
        return f"of each wheel one or, on an edge, two; {shape}"
    wheel = config.wheels[0]
    kind = config.type_of(config.wheels[0])
    psi = -kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg
    return f"one of {kind.rollers}{in_rows(kind)} or, on an edge, two; psi = {psi:g} deg: {shape}"


def in_rows(kind: WheelType) -> str:
    return f" in {len(kind.rows)} rows" if len(kind.rows) > 1 else ""


def air_reason(config: Config) -> str:
    count = sum(config.type_of(wheel).rollers for wheel in config.wheels)
    return f"{count - len(config.wheels)} of {count} keep their axial rates exactly: frictionless bearings"


def load_reason(config: Config, carried: bool) -> str:
    weight = "the weight less the vertical force"
    if config.floor.slope_deg:
        weight = "what of weight and external force is normal to the floor"
    if not config.chassis:
        return f"multiplier of the floor: {weight}"
    if not carried:
        return f"multipliers of the floor: {weight}, in equal shares"
    how = ", exactly" if len(config.wheels) == 3 else ": chassis on equal springs"
    return f"from heave, roll, pitch{how}; lift-off, touch-down are events"


def servo_reason(config: Config, carried: bool) -> str:
    if carried:
        return "the wheels carry roll and pitch"
    return f"torque about {'chassis x and y' if config.chassis else 'h'}, multiplier of the upright constraint"


def chassis_reason(config: Config) -> str:
    if not config.chassis:
        return "the scene has none"
    mass = f"{config.chassis.mass:g} kg"
    inertia = f"Izz = {config.chassis.inertia[2]:g} kg m^2"
    return f"{mass}, {inertia}; what drives a wheel acts back on it"
