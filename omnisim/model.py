"""What of the physics a scene asks for, and what is left out, each with its reason."""

from typing import NamedTuple

from omnisim.config import Config, Drive, Friction, Roller, unused_keys


class Part(NamedTuple):
    """A part of the model: how many states it has (0: algebra only), and why it is there or not."""

    name: str
    modelled: bool
    states: int
    why: str


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
        lines = [f"modelled: {self.states} states"]
        lines += [
            f"  {part.name:<{width}}  {part.states or '-':>3}  {part.why}" for part in self.parts if part.modelled
        ]
        lines += ["left out:"]
        lines += [f"  {part.name:<{width}}       {part.why}" for part in self.parts if not part.modelled]
        if self.unused:
            lines += [f"not used by this scene: {', '.join(self.unused)}"]
        return "\n".join(lines)


def describe(config: Config) -> Model:
    """The model of a validated scene: one bare wheel."""
    wheel = config.wheels[0]
    kind = config.type_of(wheel)
    count, psi = kind.roller_count, -kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg
    implicit = config.solver.tracking == "implicit"
    bearings, patch = kind.roller.has_bearing_friction, config.friction.contact_torque != "none"
    contacts = f"one of {count} or, on an edge, two; psi = {psi:g} deg: exact profile, rigid contact"
    parts = (
        Part("plane motion", True, 6, "x, y and yaw of the wheel; the servo holds it upright on the flat floor"),
        Part("spin", True, 2, f"wheel '{wheel.name}' of type '{wheel.type}': R = {kind.radius:g} m"),
        Part("rollers in contact", True, 0 if bearings else 2, contacts),
        Part(
            "roller rates" if bearings else "rollers in the air",
            bearings,
            count * bearings,
            air_reason(count, bearings),
        ),
        Part("works", True, 3 + bearings, "losses, drive and wrench work, integrated for the energy balance"),
        Part("rho", implicit, 3 * count * implicit, rho_reason(count, implicit)),
        Part("normal force", True, 0, "multiplier of the floor: the weight less the vertical force"),
        Part("servo torque", True, 0, "multiplier of the upright constraint"),
        Part("friction", config.friction.law != "none", 0, friction_reason(config.friction)),
        Part("drive", wheel.drive.kind != "free", 0, drive_reason(wheel.drive)),
        Part("wrench", bool(config.wrench.times), 0, wrench_reason(config)),
        Part("chassis", False, 0, "the scene has none"),
        Part("heave, roll and pitch", False, 0, "the floor and the servo take them away"),
        Part("contact torque", patch, 0, patch_reason(config.friction)),
        Part("bearing friction", bearings, 0, bearing_reason(kind.roller)),
    )
    return Model(parts, unused_keys(config))


def rho_reason(count: int, implicit: bool) -> str:
    if implicit:
        return f"implicit tracking integrates the unit vector of each of the {count} rollers"
    return "explicit tracking has the contact point in closed form"


def air_reason(count: int, bearings: bool) -> str:
    if bearings:
        return f"all {count}, since their bearings have friction"
    return f"{count - 1} keep their axial rates exactly: frictionless bearings"


def patch_reason(friction: Friction) -> str:
    if friction.contact_torque == "none":
        return "zero about the normal, as in the paper"
    return f"Contensou's law for Hertz pressure on a patch of radius {friction.patch_radius:g} m"


def bearing_reason(roller: Roller) -> str:
    if not roller.has_bearing_friction:
        return "the scene asks for none"
    viscous, coulomb = f"{roller.bearing_viscosity:g} N m s", f"{roller.bearing_torque:g} N m"
    return f"viscous {viscous}; Coulomb {coulomb}, changing its sign over {roller.bearing_rate:g} rad/s"


def friction_reason(friction: Friction) -> str:
    mu, slip_speed = f"{friction.coefficient:g}", f"{friction.slip_speed:g} m/s"
    return {
        "coulomb": f"F = -{mu} N v / |v| while slipping, a multiplier while sticking; every change is an event",
        "regularized": f"F = -{mu} N v / sqrt(|v|^2 + eps^2), eps = {slip_speed}",
        "saturated": f"F = -{mu} N v / max(|v|, eps), eps = {slip_speed}; the kink is an event",
        "viscous": f"F = -b v, b = {friction.viscosity:g} N s/m, whatever the normal force",
        "none": "the law is none: no tangential force",
    }[friction.law]


def drive_reason(drive: Drive) -> str:
    if drive.kind == "free":
        return "the wheel spins freely"
    times, torques = drive.table
    return (
        f"torque {torques[0]:g} N m" if len(times) == 1 else f"torque table of {len(times)} points, knots are step ends"
    )


def wrench_reason(config: Config) -> str:
    wrench = config.wrench
    if not wrench.times:
        return "no external force"
    return f"table of {len(wrench.times)} points in the {wrench.frame} frame, at the wheel centre"
