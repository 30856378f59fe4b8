"""Parts of the model of a scene that machines of all kinds may have, each with its reason."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from math import isfinite, radians, sin
from typing import NamedTuple

from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import places_in
from omnisim.scene.drive_schema import Drive
from omnisim.scene.drives import drive_law, motor_of
from omnisim.scene.ideal_kinematics import rms_distance, undetermined, wheel_rows
from omnisim.scene.schema import Config, Friction, Wheel
from omnisim.scene.wheel_schema import Roller


class Part(NamedTuple):
    """A part of the model: how many states it has (0: algebra only), and why it is there or not."""

    name: str
    modelled: bool
    states: int
    why: str


def bearing_loads(config: Config) -> Part:
    loads = config.bearing_loads
    why = "force and moment of every bearing, from the accelerations of a row"
    return Part("bearing loads", loads, 0, why if loads else "output.bearing_loads = true writes them")


def driven(config: Config, parameters: Parameters) -> Iterator[Part]:
    """States of drives, works, and odometry."""
    machine = parameters.machine
    at = places_in(parameters)
    if any(wheel.drive.controlled for wheel in config.wheels):
        why = "integrated errors of the spin rates" if machine.integrals else integral_reason(config.wheels)
        yield Part("drive integrals", bool(machine.integrals), at.current - at.integral, why)
    if machine.motors:
        currents = at.friction_loss - at.current
        settled = "currents follow their voltages at once"
        why = inductance_reason(config.wheels) if machine.currents else settled
        yield Part("motor inductance", bool(machine.currents), currents, why)
    why = "losses, drive and wrench work, integrated for the energy balance"
    yield Part("works", True, at.odometry - at.friction_loss, why)
    if config.chassis:
        yield Part("odometry", bool(machine.odometry), at.rho - at.odometry, odometry_reason(config, machine.odometry))


def drives(wheels: Sequence[Wheel]) -> Iterator[Part]:
    """One part for each kind of drive in use, and what is left out of them."""
    kinds = dict.fromkeys(wheel.drive.kind for wheel in wheels)
    for kind in sorted(kinds, key=lambda kind: kind == "free"):
        having: dict[str, list[Wheel]] = {}
        for wheel in wheels:
            if wheel.drive.kind == kind:
                having.setdefault(drive_reason(wheel.drive), []).append(wheel)
        why = "; ".join(f"{names(some, wheels)}{text}" for text, some in having.items())
        yield Part("drive" if kind == "free" else f"{kind} drive", kind != "free", 0, why)
    if any(wheel.drive.rotor_inertia > 0.0 for wheel in wheels):
        yield Part("rotor gyroscopy", False, 0, "a yawing machine does not feel its spinning rotors")


def names(some: Sequence[Wheel], wheels: Sequence[Wheel]) -> str:
    """Which wheels, to begin a sentence with; empty for the only one."""
    if len(wheels) == 1:
        return ""
    return "all wheels: " if len(some) == len(wheels) else f"{', '.join(wheel.name for wheel in some)}: "


def wheels_reason(config: Config) -> str:
    kinds = Counter(wheel.type for wheel in config.wheels)
    sizes = {name: f"of type '{name}': R = {config.wheel_types[name].radius:g} m" for name in kinds}
    if not config.chassis:
        return f"wheel '{config.wheels[0].name}' {sizes[config.wheels[0].type]}"
    return "; ".join(f"{count} wheel{'s' * (count > 1)} {sizes[name]}" for name, count in kinds.items())


def friction_reason(friction: Friction, thin: bool = False) -> str:
    """The law of friction; thin: slip within slip_speed is taken for relaxed."""
    mu = f"{friction.coefficient:g}"
    slip_speed = f"{friction.slip_speed:g} m/s"
    return {
        "coulomb": f"F = -{mu} N v / |v| slipping, a multiplier sticking; every change is an event",
        "regularized": f"F = -{mu} N v / sqrt(|v|^2 + eps^2), eps = {slip_speed}",
        "saturated": f"F = -{mu} N v / max(|v|, eps), eps = {slip_speed}; "
        + ("within it v has relaxed to -eps F / (mu N)" if thin else "the kink is an event"),
        "brush": f"rubber creeps: F = -{friction.creep_stiffness:g} N v / V at small slip, {mu} N where all slides",
        "viscous": f"F = -b v, b = {friction.viscosity:g} N s/m, whatever the normal force",
        "none": "the law is none: no tangential force",
    }[friction.law]


def drive_reason(drive: Drive) -> str:
    if drive.kind == "free":
        return "spinning freely"
    if drive.kind == "torque":
        return f"torque {given(drive, 'N m')}"
    if drive.kind == "follow":
        return f"turned as {len(drive.times)} angles say (knots are step ends), by the torque that it takes"
    return rate_reason(drive) if drive.kind == "rate" else motor_reason(drive)


def rate_reason(drive: Drive) -> str:
    target = "of the command" if drive.follows_command else given(drive, "rad/s")
    integral = f" and {drive.integral:g} N m/rad" if drive.integral else ""
    limit = f", limit {drive.torque_limit:g} N m (reaching it is an event)" if isfinite(drive.torque_limit) else ""
    return f"rate {target}, gain {drive.proportional:g} N m s/rad{integral}{limit}"


def motor_reason(drive: Drive) -> str:
    law, motor = drive_law(drive), motor_of(drive)
    windings = f"{motor.resistance:.4g} ohm, {motor.constant / drive.gear_ratio:.4g} N m/A"
    sheet = " (from its data sheet)" if drive.nominal_voltage else ""
    rotor = f", rotor {drive.rotor_inertia:g} kg m^2" if drive.rotor_inertia else ""
    viscous = f", viscous friction {motor.viscosity:.4g} N m s" if motor.viscosity else ""
    coulomb = f", Coulomb friction {motor.friction_torque:.4g} N m" if motor.friction_torque else ""
    limits = ((law.limit, "V"), (drive.current_limit, "A"))
    within = " and ".join(f"{limit:g} {unit}" for limit, unit in limits if isfinite(limit))
    limit = f", within {within} (reaching a limit is an event)" if within else ""
    asked = controller_reason(drive) if drive.controlled else f"voltage {given(drive, 'V')}"
    return f"{asked}{limit}; {windings}{sheet}, gear {drive.gear_ratio:g}{rotor}{viscous}{coulomb}"


def controller_reason(drive: Drive) -> str:
    target = "of the command" if drive.follows_command else given(drive, "rad/s")
    gains = ((drive.proportional, "V s/rad"), (drive.integral, "V/rad"), (drive.derivative, "V s^2/rad"))
    told = ", ".join(f"{gain:g} {unit}" for gain, unit in gains if gain)
    sampled = f", sampled every {drive.sample_time:g} s" if drive.sample_time else ""
    return f"rate {target}, gains {told}{sampled}"


def given(drive: Drive, unit: str) -> str:
    """The input of a drive: a number or a table."""
    times, values = drive.table
    return f"{values[0]:g} {unit}" if len(times) == 1 else f"by table of {len(times)} points (knots are step ends)"


def integral_reason(wheels: Sequence[Wheel]) -> str:
    if any(wheel.drive.controlled and wheel.drive.integral for wheel in wheels):
        return "sampled controllers add up their errors"
    return "no drive has an integral gain"


def inductance_reason(wheels: Sequence[Wheel]) -> str:
    """Time constants L / R_a of the currents."""
    motors = [drive_law(wheel.drive).motor for wheel in wheels]
    settle = dict.fromkeys(motor.inductance / motor.resistance for motor in motors if motor and motor.inductance)
    return f"currents settle in {', '.join(f'{time:.3g} s' for time in settle)} (L / R_a)"


def odometry_reason(config: Config, told: bool) -> str:
    if told:
        return "x, y as ideal wheels without slip report them; yaw follows from spin angles"
    motions = undetermined(wheel_rows(config), rms_distance(config))
    return f"spin rates do not tell the motion; they leave open: {', '.join(motions)}"


def command_reason(config: Config) -> str:
    if not config.command:
        return "the scene has none"
    points = len(config.command.times)
    twist = f"twist table of {points} points" if points > 1 else "constant twist"
    return f"{twist}; ideal wheels give drives their target rates"


def slope_reason(config: Config) -> str:
    floor = config.floor
    along = config.world.gravity * sin(radians(config.floor.slope_deg))
    if not along:
        return "the floor is level" if config.world.gravity else "there is no gravity"
    uphill = f"{floor.slope_deg:g} deg, uphill at {floor.uphill_deg:g} deg from x"
    return f"{uphill}: gravity along the floor {along:.4g} m/s^2"


def wrench_reason(config: Config) -> str:
    wrench = config.wrench
    if not wrench.times:
        return "no external force"
    where = "at the chassis' centre of mass" if config.chassis else "at the wheel centre"
    what = f"table of {len(wrench.times)} points" if len(wrench.times) > 1 else "constant"
    return f"{what} in the {wrench.frame} frame, {where}"


def patch_reason(friction: Friction) -> str:
    if friction.contact_torque == "none":
        return "zero about the normal, as in the paper"
    return f"Contensou's law for Hertz pressure on a patch of radius {friction.patch_radius:g} m"


def bearing_reason(config: Config) -> str:
    return by_type(config, lambda roller: bearing_law(roller) if roller.has_bearing_friction else "")


def rolling_reason(config: Config) -> str:
    return by_type(config, lambda roller: rolling_law(roller) if roller.has_rolling_resistance else "")


def by_type(config: Config, law: Callable[[Roller], str]) -> str:
    """What the rollers of each type in use have, by its name if there are several types; `law` is empty if nothing."""
    kinds = {wheel.type: law(config.type_of(wheel).roller) for wheel in config.wheels}
    having = {name: told for name, told in kinds.items() if told}
    if len(kinds) == 1 and having:
        return next(iter(having.values()))
    return "; ".join(f"type '{name}': {told}" for name, told in having.items()) or "the scene asks for none"


def rolling_law(roller: Roller) -> str:
    moment = f"{roller.rolling_resistance:g} N m by N of load"
    return f"{moment} on every roller on the floor, changing its sign over {roller.rolling_rate:g} rad/s"


def bearing_law(roller: Roller) -> str:
    viscous, coulomb = f"{roller.bearing_viscosity:g} N m s", f"{roller.bearing_torque:g} N m"
    return f"viscous {viscous}, Coulomb {coulomb} changing its sign over {roller.bearing_rate:g} rad/s"
