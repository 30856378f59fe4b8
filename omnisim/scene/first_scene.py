"""The first scene of a robot, as text: what is not on its data sheet is estimated, and marked ESTIMATED.

scene_text(Robot("mecanum", wheel_radius=0.076, mass=12.0, motor=Controller(2.0), track=0.3, wheelbase=0.35))
"""

from omnisim.scene.bought_wheel import STEP, BoughtWheel, bought_wheel
from omnisim.scene.design import (
    FRICTION,
    KINDS,
    ROLLER_DENSITY,
    DesignError,
    Part,
    Robot,
    Square,
    Wheel,
    part,
    short,
    square,
    wheels,
)

ESTIMATED = "# ESTIMATED"


def scene_text(robot: Robot, command: str = "omnisim new") -> str:
    """The scene, as TOML with comments; `command` is how to write it again. Raises DesignError."""
    places = wheels(robot)
    bought = bought_wheel(robot.wheel) if robot.wheel else None
    if bought:
        kind, each, wheel_type = bought.name, bought.mass, _bought_type(bought)
    else:
        own = part(robot)
        kind, each, wheel_type = KINDS[robot.kind].wheel, own.mass, _wheel_type(robot, own)
    chassis = robot.mass - len(places) * each
    if chassis <= 0.0:
        much = f"{len(places)} wheels weigh {len(places) * each:.3g} kg"
        asked = "" if bought else "; what is the mass of one wheel?"
        raise DesignError(f"a machine of {robot.mass:g} kg is too light: its {much}{asked}")
    usual = bought.coefficient if bought else FRICTION
    friction = usual if robot.friction is None else robot.friction
    motion = square(robot, friction)
    blocks = [
        _head(robot, command, motion),
        _laws(robot, bought, motion, friction),
        wheel_type,
        _chassis(robot, chassis),
        _wheels(robot, kind, places),
        _command(robot, motion),
    ]
    return "\n".join(blocks)


def _head(robot: Robot, command: str, motion: Square) -> str:
    return f"""\
# {KINDS[robot.kind].told.capitalize()}: {robot.mass:g} kg, wheels of {robot.wheel_radius:g} m radius.
#
# Written by: {command}
# What is ESTIMATED says so: replace it by what you know. `omnisim info` shows what follows from it.
schema = 1
title = "{robot.kind} of {robot.mass:g} kg drives a square"
"""


def _laws(robot: Robot, bought: BoughtWheel | None, motion: Square, friction: float) -> str:
    """Time, friction, and what a packaged wheel needs beside."""
    law, step, tables = (bought.law, bought.step, bought.tables) if bought else (('law = "coulomb"',), STEP, "")
    lines = "\n".join(law)
    return f"""\
[time]
end = {4.0 * motion.leg + 0.5:.6g} # s
step = {step:g}
output_interval = 0.01
{tables}
[friction]
{lines}
coefficient = {friction:g} {_marked(robot.friction)}of rollers on the floor
"""


def _bought_type(wheel: BoughtWheel) -> str:
    return f"""\
# {wheel.told}: `omnisim data {wheel.name}` has its numbers and their sources.
[wheel_types.{wheel.name}]
from = "{wheel.name}" # what is given here as well wins
"""


def _wheel_type(robot: Robot, wheel: Part) -> str:
    kind = KINDS[robot.kind]
    shape = wheel.shape
    rows = "" if kind.rows == 1 else ", in two rows, which a scene has as one"
    known = "" if robot.wheel_mass is None else f"{robot.wheel_mass:g} kg less the rollers; "
    disk = f"mass = {short(wheel.disk_mass)}, hub_radius = {short(wheel.hub)}, width = {short(wheel.width)}"
    lines = [
        f"[wheel_types.{kind.wheel}]",
        f"radius = {short(robot.wheel_radius)} # m",
        f"roller_distance = {short(shape.roller_distance)} {_marked(robot.roller_diameter)}"
        f"rollers {2e3 * (shape.radius - shape.roller_distance):.4g} mm thick amid",
        f"roller_count = {wheel.rollers} {_marked(robot.rollers)}of one wheel{rows}",
        f"roller_angle_deg = {short(kind.psi_deg)}",
        f"disk = {{ {disk} }} {ESTIMATED}: {known}a cylinder",
        f"roller = {{ density = {short(ROLLER_DENSITY)}, bore_radius = {short(wheel.bore)} }} {ESTIMATED}: kg/m^3, m",
    ]
    return "\n".join([*lines, ""])


def _marked(given: object) -> str:
    return f"{ESTIMATED}: " if given is None else "# "


def _chassis(robot: Robot, mass: float) -> str:
    size = ", ".join(map(short, robot.size or _size(robot)))
    return f"""\
# A box, half a wheel radius above the floor: its inertia, and its middle as centre of mass. {ESTIMATED[2:]}
[chassis]
mass = {short(mass)} # kg: {robot.mass:g} kg less the wheels
size = [{size}] {_marked(robot.size)}length, width, height
"""


def _size(robot: Robot) -> tuple[float, float, float]:
    """A box over the wheels, as high as they are."""
    if robot.kind == "kiwi":
        return 2.0 * robot.distance, 2.0 * robot.distance, 2.0 * robot.wheel_radius
    return robot.wheelbase + 2.0 * robot.wheel_radius, robot.track, 2.0 * robot.wheel_radius


def _wheels(robot: Robot, kind: str, places: list[Wheel]) -> str:
    inertia = robot.mass / len(places) * robot.wheel_radius**2  # of the machine, at one wheel
    drive = robot.motor.drive(inertia)
    blocks = [f"{ESTIMATED}: the gains of the controllers, by the mass."]
    for place in places:
        lines = [f'name = "{place.name}"', f'type = "{kind}"']
        lines += [f"position = [{short(place.x)}, {short(place.y)}]"]
        lines += [f"heading_deg = {short(place.heading)}"] * (place.heading != 0.0)
        lines += ["mirrored = true"] * place.mirrored
        blocks.append("\n".join(["[[wheels]]", *lines, f"{drive}\n"]))
    return "\n".join(blocks)


def _command(robot: Robot, motion: Square) -> str:
    """Forward, to the left, back and to the right, without a turn."""
    times, twists = [0.0], ["[0.0, 0.0, 0.0]"]
    for leg, (x, y) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1))):
        speed = f"[{short(x * motion.speed)}, {short(y * motion.speed)}, 0.0]"
        start = leg * motion.leg
        times += [start + motion.ramp, start + motion.side, start + motion.leg]
        twists += [speed, speed, "[0.0, 0.0, 0.0]"]
    return f"""\
# A square of {robot.side:g} m: forward, to the left, back, to the right; [vx, vy, yaw_rate] in m/s and rad/s.
[command]
times = [{", ".join(short(time) for time in times)}]
twist = [
{"".join(f"    {twist},{chr(10)}" for twist in twists)}]
"""
