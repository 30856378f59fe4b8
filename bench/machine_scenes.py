"""The machines of `whole_machines.py` as scenes: a platform on four mecanum wheels, and rings of omni wheels.

The platform has the size of common ones (22.7 kg in all, wheels of 100 mm with nine rollers at 45 deg). It follows a
twist that rises for RAMP seconds and then stays, in one of two ways:

    rate     PI controllers of the wheels follow it, with gains and a limit of a gear motor of this size
    torque   the torques by which ideal wheels would follow it, without a controller; then none, the platform coasts

A wheel that slips is held by its drive alone: its rate relaxes at proportional / J_k, about 300 1/s here (J_k about
1e-3 kg m^2), and an explicit step must resolve that while it lasts. The second way shows what is left without it.

For the C loop the platform slips on a wet floor under constant torques.
"""

import math

import numpy as np

from omnisim.dynamics.inertia import axle_inertia
from omnisim.dynamics.packing import bodies
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.scene import Scene, parse

END, RAMP = 2.0, 0.5  # s
MOTIONS = {"forward": (0.5, 0.0, 0.0), "sideways": (0.0, 0.5, 0.0), "diagonal with yaw": (0.4, 0.3, 0.5)}
CONTROLLER = 'kind = "rate", proportional = 0.3, integral = 2.0, torque_limit = 5.0'
PLACES = {
    "front_left": (0.2, 0.15),
    "front_right": (0.2, -0.15),
    "rear_left": (-0.2, 0.15),
    "rear_right": (-0.2, -0.15),
}
PLATFORM = """
schema = 1
time = {{ end = {end!r}, step = {step!r}, output_interval = 0.1 }}
solver = {{ method = "{method}" }}
friction = {{ law = "coulomb", coefficient = 0.7 }}
chassis = {{ mass = 20.02, center_of_mass = [0.0, 0.0, 0.1], inertia = [0.3, 0.6, 0.8] }}
command = {{ times = [0.0, {ramp!r}], twist = [[0.0, 0.0, 0.0], {twist}] }}
{wheels}
[wheel_types.wheel]
radius = 0.05
roller_distance = 0.04
roller_count = 9
roller_angle_deg = 45.0
disk = {{ mass = 0.4, inertia_axle = 5e-4, inertia_diameter = 3e-4 }}
roller = {{ mass = 0.03, inertia_axial = 1.2e-6, inertia_transverse = 5e-6 }}
"""
WHEEL = """
[[wheels]]
name = "{name}"
type = "wheel"
position = {place}
heading_deg = {heading!r}
mirrored = {mirrored}
drive = {{ {drive} }}
"""
RING = """
schema = 1
time = {{ end = {end!r}, step = {step!r}, output_interval = 0.1 }}
friction = {{ law = "{law}", coefficient = 0.8{slip_speed} }}
chassis = {{ mass = 10.0, center_of_mass = [0.0, 0.0, 0.1], inertia = [0.1, 0.1, 0.2] }}
{wheels}
[wheel_types.wheel]
radius = 0.05
roller_distance = 0.04
roller_count = {rollers}
roller_angle_deg = 0.0
disk = {{ mass = 0.5, inertia_axle = 0.0004, inertia_diameter = 0.00022 }}
roller = {{ mass = 0.03, inertia_axial = 6e-06, inertia_transverse = 9e-06 }}
"""
SLIP_SPEED = {"coulomb": "", "regularized": ", slip_speed = 0.05"}


def platform(motion: str, drive: str, method: str, step: float, end: float = END) -> Scene:
    """The platform in one of MOTIONS by drives of kind "rate" or "torque"."""
    values = {"end": end, "ramp": RAMP, "method": method, "step": step, "twist": list(MOTIONS[motion])}
    following = parse(PLATFORM.format(**values, wheels=platform_wheels([CONTROLLER] * len(PLACES))), "platform")
    if drive == "rate":
        return following
    times = [0.0, RAMP, RAMP]
    drives = [
        f'kind = "torque", times = {times}, torque = {[torque, torque, 0.0]}'
        for torque in ideal_torques(following, np.divide(MOTIONS[motion], RAMP))
    ]
    text = PLATFORM.format(**values, wheels=platform_wheels(drives))
    return parse(uncommanded(text), "platform")


def slipping_platform(step: float = 1e-4, end: float = 1.0) -> Scene:
    """The platform with its load off the centre on a slippery floor, by regularized friction and constant torques.

    Its wheels start out of step with its motion, and the torques come near what the floor can take: contacts slip as
    fast as the slip speed of the law and faster, which therefore is not stiff at this step.
    """
    drives = [f'kind = "torque", torque = {torque!r}' for torque in (0.36, 0.25, 0.3, 0.33)]
    values = {"end": end, "ramp": RAMP, "method": "rk4", "step": step, "twist": [0.0, 0.0, 0.0]}
    text = uncommanded(PLATFORM.format(**values, wheels=platform_wheels(drives)))
    rates = zip(PLACES, (20.0, 6.0, 4.0, 16.0), strict=True)
    slipping = ["friction.law=regularized", "friction.slip_speed=0.05", "friction.coefficient=0.2"]
    moving = ["initial.velocity=[0.6, -0.3]", "initial.yaw_rate=1.0", "time.output_interval=0.05"]
    moving += [f"wheels.{name}.spin_rate={rate}" for name, rate in rates]
    return parse(text, "slipping platform", [*slipping, *moving, "chassis.center_of_mass=[0.02, 0.01, 0.1]"])


def uncommanded(text: str) -> str:
    return "\n".join(line for line in text.splitlines() if not line.startswith("command"))


def platform_wheels(drives: list[str]) -> str:
    return "".join(
        WHEEL.format(name=name, place=[x, y], heading=0.0, mirrored=str(x * y < 0.0).lower(), drive=drive)
        for (name, (x, y)), drive in zip(PLACES.items(), drives, strict=True)
    )


def ideal_torques(scene: Scene, acceleration: np.ndarray) -> list[float]:
    """Torques (N m) that give the machine this acceleration of its twist from rest if its wheels are ideal.

    rows^T (torques - J_k rows a) = diag(M, M, I_z) a, the least torques of all that do.
    """
    config = scene.config
    rows, whole = wheel_rows(config), bodies(config)
    kind = config.wheel_types["wheel"]
    inertia = axle_inertia(kind, math.sin(math.radians(kind.roller_angle_deg)))
    forces = np.array([whole.mass, whole.mass, whole.yaw_inertia]) * acceleration
    return (np.linalg.pinv(rows.T) @ forces + inertia * rows @ acceleration).tolist()


def ring(wheels: int, law: str, step: float, end: float, rollers: int = 8) -> Scene:
    """So many omni wheels in a ring, driven from rest by constant torques: forward and round, every contact sticks."""
    text = ""
    for i in range(wheels):
        angle = 2.0 * math.pi * i / wheels
        place, heading = [0.2 * math.cos(angle), 0.2 * math.sin(angle)], math.degrees(angle) + 90.0
        drive = f'kind = "torque", torque = {0.02 + 0.05 * math.cos(math.radians(heading))!r}'
        text += WHEEL.format(name=f"w{i}", place=place, heading=heading, mirrored="false", drive=drive)
    return parse(RING.format(**locals() | {"wheels": text, "slip_speed": SLIP_SPEED[law]}), "ring")
