"""The rules across the keys of a scene: each yields the problems that it finds."""

import math
from collections.abc import Iterator
from itertools import pairwise

from omnisim.base.keeping import kept
from omnisim.base.methods import EXPLICIT, METHODS
from omnisim.scene.drive_schema import CONTROLLER, DATA_SHEET, DRIVE_KEYS, MOTOR_CONSTANTS, Drive
from omnisim.scene.drives import SHEET_TOLERANCE, data_sheet, sheet_constants
from omnisim.scene.problems import Problem, allowed_at, did_you_mean
from omnisim.scene.roller_rules import DECIMAL_TOLERANCE, row_rules, wheel_type_rules
from omnisim.scene.schema import FRICTION_KEYS, GRID_TOLERANCE, Config, Wheel, is_whole
from omnisim.scene.toml_text import KeyPath

KEYS_OF_DRIVES = {kind: keys.all for kind, keys in DRIVE_KEYS.items()}
MAX_STEPS = 10**10
SAME_ANGLE = 1e-9  # rad


def _time_rules(config: Config) -> Iterator[Problem]:
    """Of step, output interval and end, as far as they are given, each goes into the next."""
    time = config.time
    if time.step is None and config.solver.error is None:
        instead = "or the scene has a solver.error, which picks one"
        yield Problem(("time", "step"), f"missing; must be {allowed_at(('time', 'step'))}, {instead}")
        return
    times = {"step": time.step, "output_interval": time.interval, "end": time.end}
    given = [(key, value) for key, value in times.items() if value is not None]
    (finest, shortest), *_ = given
    if (steps := time.end / shortest) > MAX_STEPS * (1 + GRID_TOLERANCE):
        yield Problem(("time", finest), f"end / {finest} = {steps:.6g} steps; must be at most {MAX_STEPS:.0e}")
        return
    for (short, a), (long, b) in pairwise(given):
        if not is_whole(b / a):
            ratio = f"{long} / {short} = {b!r} / {a!r} = {b / a:.12g}"
            yield Problem(("time", given[-2][0]), f"{ratio}; must be an integer (to 1e-9)")
            return  # one of the three times is wrong: one problem


def _formulation_rules(config: Config) -> Iterator[Problem]:
    """Implicit steps solve for all states that forces depend on: of every body these are too many."""
    method, explicit = config.solver.method, [name for name, method in METHODS.items() if method.choice == EXPLICIT]
    if config.solver.formulation == "multibody" and method not in explicit:
        names = ", ".join(f"'{name}'" for name in explicit)
        yield Problem(("solver", "method"), f"must be one of {names} with formulation = 'multibody'")


def _friction_rules(config: Config) -> Iterator[Problem]:
    law = config.friction.law
    for key in FRICTION_KEYS[law]:
        if key not in config.friction.model_fields_set:
            allowed = allowed_at(("friction", key))
            yield Problem(("friction", key), f"missing; law = '{law}' needs {allowed}")


def _creep_rules(config: Config) -> Iterator[Problem]:
    """Rubber slides at a ratio of slip of 1 at most: F = -g v then relaxes slip at no more than the rate of g."""
    friction = config.friction
    least = 3.0 * friction.coefficient
    given = friction.law == "brush" and "creep_stiffness" in friction.model_fields_set
    if given and friction.creep_stiffness < least * (1.0 - DECIMAL_TOLERANCE):
        allowed = f"at least 3 coefficient = {least:g}; at that it slides from a slip ratio of 1 on"
        yield Problem(("friction", "creep_stiffness"), f"must be {allowed}")


def _contact_torque_rules(config: Config) -> Iterator[Problem]:
    """Contensou's law is smooth where the slip is; the set-valued law with a torque is another one."""
    friction = config.friction
    if friction.contact_torque == "none":
        return
    if friction.law != "regularized":
        yield Problem(
            ("friction", "contact_torque"), f"must be \"none\" with law = '{friction.law}'; only 'regularized' has one"
        )
    elif "patch_radius" not in friction.model_fields_set:
        allowed = allowed_at(("friction", "patch_radius"))
        yield Problem(("friction", "patch_radius"), f"missing; contact_torque = 'contensou' needs {allowed}")


def _wheel_rules(config: Config) -> Iterator[Problem]:
    names = [wheel.name for wheel in config.wheels]
    for index, wheel in enumerate(config.wheels):
        path = ("wheels", index)
        if wheel.name in names[:index]:
            yield Problem((*path, "name"), "must be unique; another wheel has this name")
        if wheel.type not in config.wheel_types:
            known = ", ".join(config.wheel_types)
            hint = did_you_mean(wheel.type, config.wheel_types)
            yield Problem((*path, "type"), f"no such wheel type{hint or '.'} Wheel types: {known}")
        elif isinstance(wheel.roller_rates, tuple):
            count = config.type_of(wheel).rollers
            given = len(wheel.roller_rates)
            if given != count:
                rows = len(config.type_of(wheel).rows)
                product = "roller_count" if rows == 1 else f"roller_count * {rows}"
                allowed = f"one finite number, or a list of {product} = {count} finite numbers"
                yield Problem((*path, "roller_rates"), f"must be {allowed}, not {given}")
        for problem in _drive_problems(wheel.drive):
            yield problem._replace(path=(*path, *problem.path[2:]))
        if wheel.drive.kind == "follow":
            yield from _follow_rules(path, wheel, config.time.end)


def _place_rules(config: Config) -> Iterator[Problem]:
    """A chassis says where its wheels are; without one a wheel stands where [initial] puts it, and nowhere else."""
    if config.chassis:
        for index, wheel in enumerate(config.wheels):
            if "position" not in wheel.model_fields_set:
                path = ("wheels", index, "position")
                yield Problem(path, f"missing; on a chassis it must be {allowed_at(path)}, of the wheel centre")
    elif len(config.wheels) > 1:
        yield Problem(("wheels", 1), "several wheels need a [chassis]; without one a scene has one wheel")
    else:
        yield from _bare_wheel_rules(config.wheels[0])


def _bare_wheel_rules(wheel: Wheel) -> Iterator[Problem]:
    for key, value, zero, instead in (
        ("position", wheel.position, "[0, 0]", "position"),
        ("heading_deg", wheel.heading_deg, "0", "yaw_deg"),
    ):
        if value not in (0.0, (0.0, 0.0)):
            allowed = f"absent or {zero} for a wheel without a chassis; [initial] {instead} places it"
            yield Problem(("wheels", 0, key), f"must be {allowed}")


@kept
def _drive_problems(drive: Drive) -> tuple[Problem, ...]:
    """Of a drive, as if it were that of the first wheel."""
    return tuple(_drive_rules(("wheels", 0, "drive"), drive))


def _drive_rules(path: KeyPath, drive: Drive) -> Iterator[Problem]:
    keys = DRIVE_KEYS[drive.kind]
    present = drive.model_fields_set - {"kind"}
    for key in sorted(present - KEYS_OF_DRIVES[drive.kind]):
        yield Problem((*path, key), f"not a key of a drive with kind = '{drive.kind}'")
    if drive.kind == "dc_motor":
        yield from _motor_rules(path, drive, present)
    for key in keys.needed:
        if key not in present:
            yield Problem((*path, key), f"missing; must be {allowed_at((*path, key))}")
    given = drive.given
    if given in present:
        yield from _given_rules(path, given, getattr(drive, given), drive.times)
    elif drive.follows_command and drive.times:
        yield Problem((*path, "rate"), "missing; times need a list of as many rates")


def _follow_rules(path: KeyPath, wheel: Wheel, end: float) -> Iterator[Problem]:
    """A table of angles tells the spin at every instant of the run, and nothing else does."""
    times = wheel.drive.times
    if times and (len(times) < 2 or times[0] != 0.0 or times[-1] < end or any(a == b for a, b in pairwise(times))):
        allowed = f"two times or more, without repetition, from 0 to time.end = {end:g} or beyond"
        yield Problem((*path, "drive", "times"), f"must be {allowed}")
    angles = wheel.drive.angle
    given = "spin_angle_deg" in wheel.model_fields_set
    if given and angles and abs(math.radians(wheel.spin_angle_deg) - angles[0]) > SAME_ANGLE:
        allowed = f"absent, or where the angles of the drive begin, {math.degrees(angles[0]):.12g}"
        yield Problem((*path, "spin_angle_deg"), f"must be {allowed}")


def _motor_rules(path: KeyPath, drive: Drive, present: set[str]) -> Iterator[Problem]:
    """A voltage or a controller that gives it; constants or the data sheet that they follow from."""
    if drive.controlled and "voltage" in present:
        yield Problem((*path, "voltage"), "not beside a controller (proportional), which gives the voltage itself")
    elif "voltage" in present:
        for key in (key for key in CONTROLLER if key in present):
            yield Problem((*path, key), "is of a controller, which needs proportional and gives the voltage itself")
    elif "proportional" not in present:
        key = "proportional" if present.intersection(CONTROLLER) else "voltage"
        instead = f", or a controller gives it: {', '.join(CONTROLLER)}" if key == "voltage" else ""
        yield Problem((*path, key), f"missing; must be {allowed_at((*path, key))}{instead}")
    if drive.derivative > 0.0 and drive.sample_time is None:
        yield Problem((*path, "derivative"), "needs a sample_time: it acts on the change of rate between two samples")
    sheet = [key for key in DATA_SHEET if key in present]
    if not sheet:
        for key in ("resistance", "torque_constant"):
            if key not in present:
                instead = f", or the motor has a data sheet: {', '.join(DATA_SHEET)}"
                yield Problem((*path, key), f"missing; must be {allowed_at((*path, key))}{instead}")
        return
    for key in (key for key in MOTOR_CONSTANTS if key in present):
        yield Problem((*path, key), f"follows from the data sheet: not beside {sheet[0]}")
    if missing := [key for key in DATA_SHEET if key not in present]:
        yield Problem((*path, missing[0]), f"missing; a data sheet is all of {', '.join(DATA_SHEET)}")
    else:
        yield from _sheet_rules(path, drive)


def _sheet_rules(path: KeyPath, drive: Drive) -> Iterator[Problem]:
    """The values of a data sheet are one motor."""
    sheet = data_sheet(drive)
    if sheet.no_load_current >= sheet.stall_current:
        yield Problem((*path, "no_load_current"), f"must be below stall_current = {sheet.stall_current:g}")
        return
    motor = sheet_constants(drive)
    torque = sheet.stall_torque
    low, high = motor.least_stall, motor.most_stall
    if not low * (1.0 - SHEET_TOLERANCE) <= torque <= high * (1.0 + SHEET_TOLERANCE):
        rest = f"nominal_voltage, no_load_speed and the currents (torque constant {motor.torque_constant:.4g} N m/A)"
        allowed = f"{low:.4g} to {high:.4g} N m, to {SHEET_TOLERANCE:.0%}, by {rest}"
        gear = "; if its gear takes the rest, give the motor's own values and the gear_ratio" if torque < low else ""
        yield Problem((*path, "stall_torque"), f"contradicts the rest of the data sheet: must be {allowed}{gear}")


def _sample_rules(config: Config) -> Iterator[Problem]:
    """Controllers read their rates at the ends of steps."""
    time = config.time
    error = config.solver.error
    unit = time.output_interval / 1000 if error is not None else time.step
    for index, wheel in enumerate(config.wheels):
        sample_time = wheel.drive.sample_time
        if sample_time is not None and unit is not None and not is_whole(sample_time / unit):
            what = "time.step" if error is None else "output_interval / 1000, since solver.error picks the step"
            yield Problem(("wheels", index, "drive", "sample_time"), f"must be a multiple of {unit:g} s, {what}")


def _given_rules(
    path: KeyPath, key: str, value: float | tuple[float, ...], times: tuple[float, ...]
) -> Iterator[Problem]:
    """One number, or a list of numbers and one of times."""
    if isinstance(value, float):
        if times:
            allowed = f"a list of {len(times)} finite numbers, as many as times"
            yield Problem((*path, key), f"must be {allowed}")
    elif not times:
        yield Problem((*path, "times"), f"missing; a list for {key} needs a list of as many times")
    else:
        yield from _table_rules(path, times, **{key: value})


def _wrench_rules(config: Config) -> Iterator[Problem]:
    wrench = config.wrench
    if wrench.times:
        yield from _table_rules(("wrench",), wrench.times, force=wrench.force, yaw_torque=wrench.yaw_torque)
    elif "wrench" in config.model_fields_set:
        yield Problem(("wrench", "times"), f"missing; must be {allowed_at(('wrench', 'times'))}")


def _command_rules(config: Config) -> Iterator[Problem]:
    """A command moves a chassis, and some wheel follows it; no wheel waits for one in vain."""
    followers = [index for index, wheel in enumerate(config.wheels) if wheel.drive.follows_command]
    if not config.command:
        for index in followers:
            path = ("wheels", index, "drive", "rate")
            if not config.wheels[index].drive.times:  # a list of times without rates is a problem already
                allowed = f"must be {allowed_at(path)}, or the scene has a [command] that the wheel follows"
                yield Problem(path, f"missing; {allowed}")
    elif not config.chassis:
        yield Problem(("command",), "needs a [chassis] to move")
    elif not followers:
        yield Problem(
            ("command",),
            "no wheel follows it; needs a drive with kind = 'rate' or a controlled dc_motor, without a rate of its own",
        )
    else:
        yield from _table_rules(("command",), config.command.times, twist=config.command.twist)


def _table_rules(path: KeyPath, times: tuple[float, ...], **columns: tuple) -> Iterator[Problem]:
    for index in range(1, len(times)):
        if times[index] < times[index - 1]:
            allowed = f"at least {times[index - 1]!r}: times never decrease"
            yield Problem((*path, "times", index), f"must be {allowed}")
            break
    for key, column in columns.items():
        if column and len(column) != len(times):
            allowed = f"a list as long as times ({len(times)}), not {len(column)}"
            yield Problem((*path, key), f"must be {allowed}")


RULES = (
    _time_rules,
    _formulation_rules,
    _friction_rules,
    _creep_rules,
    _contact_torque_rules,
    wheel_type_rules,
    row_rules,
    _wheel_rules,
    _sample_rules,
    _place_rules,
    _wrench_rules,
    _command_rules,
)
