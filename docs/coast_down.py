"""How a mecanum machine coasts: which rolling resistance and bearing friction its deceleration tells of, and what they
cost at full power.

    python -m docs.coast_down           writes the table of docs/pages/rolling.md anew

Teams of robot competitions publish the deceleration of their machines without power, ahead and aside (medians of twenty:
0.90 and 1.82 m/s^2), and the speed aside by that ahead at full power (median of twelve: 0.73). Mass, wheels and motors of
those machines are not published: here they are ASSUMED, of a common size.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omnisim
from omnisim.scene.scene import parse

PAGE = Path(__file__).parent / "pages" / "rolling.md"
BEGIN, END = "<!-- python -m docs.coast_down -->\n", "<!-- end -->\n"
G = 9.81
ALONG, ACROSS = (1.0, 0.0), (0.0, 1.0)
AHEAD, ASIDE = 0.90, 1.82  # m/s^2
MASS = 13.0  # kg, of all
RADIUS, DISTANCE, ROLLERS = 0.048, 0.0385, 9
WHEEL_MASS, SPEED = 0.35, 1.2  # kg; m/s from which it coasts
INERTIA = 4.0e-4  # kg m^2, of a wheel with its rollers about its axle
EFFECTIVE = MASS + 4.0 * INERTIA / RADIUS**2  # kg
DISK = "{ mass = 0.17, inertia_axle = 1.2e-4, inertia_diameter = 7e-5 }"
ROLLER = "mass = 0.02, inertia_axial = 8e-7, inertia_transverse = 3e-6"
STALL, FREE = 2.4, 32.7  # N m, rad/s: a gear motor for 12 V of 312 rpm, as are sold for such machines
COULOMB = '{ law = "coulomb", coefficient = 0.9 }'
BRUSH = '{ law = "brush", coefficient = 0.9, creep_stiffness = 12.0, slip_speed = 2e-3 }'


class Losses(NamedTuple):
    """f of rollers (m), Coulomb torque of their bearings and of each axle (N m)."""

    resistance: float
    bearing: float
    axle: float


class Turning(NamedTuple):
    """What turns by the speed of a machine, 1/m: a roller on the floor, along it; a roller in its bearing."""

    rolling: float
    joint: float


def aside() -> Turning:
    """Of 45 deg wheels that roll aside, the mean over the way on a roller: w_t = (1 / h_q, (1 / h_q - 1 / R) / cos q)."""
    q = np.linspace(-1.0, 1.0, 2001) * math.pi / ROLLERS
    h_q = RADIUS - DISTANCE / np.cos(q)
    joint = math.sqrt(2.0) / (h_q * np.cos(q))
    rolling = np.hypot(1.0 / h_q, (1.0 / h_q - 1.0 / RADIUS) / np.cos(q))
    return Turning(*(float(np.average(rates, weights=np.cos(q))) for rates in (rolling, joint)))


def losses(part: float) -> Losses:
    """Those with which the machine decelerates as published, if rolling resistance makes this part of what is more
    aside than ahead, and bearings the rest."""
    turning = aside()
    more = (ASIDE - AHEAD) * EFFECTIVE
    resistance = part * more / (MASS * G * (turning.rolling - 1.0 / RADIUS))
    bearing = (1.0 - part) * more / (4.0 * turning.joint)
    axle = (AHEAD * EFFECTIVE - resistance * MASS * G / RADIUS) * RADIUS / 4.0
    return Losses(resistance, bearing, axle)


def scene(lost: Losses, direction: tuple[float, float], speed: float, powered: bool, friction: str) -> omnisim.Scene:
    """A machine on four 45 deg wheels that begins to roll with this speed (m/s): it coasts, its axles braked, or has
    full power."""
    wheels = []
    for x, y in ((0.2, 0.18), (0.2, -0.18), (-0.2, 0.18), (-0.2, -0.18)):
        mirrored = x * y < 0.0
        sense = direction[0] + (direction[1] if mirrored else -direction[1])
        drive = f'kind = "torque", torque = {-sense * lost.axle}'
        if powered:
            drive = f'kind = "rate", rate = {sense * FREE * (1.0 - lost.axle / STALL)}, proportional = {STALL / FREE}'
        wheels.append(
            f'{{ name = "w{len(wheels)}", type = "mecanum", position = [{x}, {y}], mirrored = {str(mirrored).lower()}, '
            f"spin_rate = {sense * speed / RADIUS}, roller_rates = {direction[1] * speed * aside().joint}, "
            f"drive = {{ {drive} }} }}"
        )
    roller = f"{ROLLER}, rolling_resistance = {lost.resistance}, bearing_torque = {lost.bearing}"
    return parse(f"""
schema = 1
scene = {{ upright = "servo" }}
time = {{ end = {2.0 if powered else 0.3}, step = 1e-3, output_interval = 0.02 }}
solver = {{ method = "auto" }}
friction = {friction}
chassis = {{ mass = {MASS - 4 * WHEEL_MASS}, center_of_mass = [0.0, 0.0, 0.08], inertia = [0.2, 0.25, 0.4] }}
wheels = [{", ".join(wheels)}]
initial = {{ velocity = [{direction[0] * speed}, {direction[1] * speed}] }}
[wheel_types.mecanum]
radius = {RADIUS}
roller_distance = {DISTANCE}
roller_count = {ROLLERS}
roller_angle_deg = 45.0
disk = {DISK}
roller = {{ {roller} }}
""")


def run(
    lost: Losses, direction: tuple[float, float], speed: float, powered: bool, friction: str = COULOMB
) -> np.ndarray:
    """Times (s) and the speeds along the direction (m/s), (2, T)."""
    trajectory = omnisim.simulate(scene(lost, direction, speed, powered, friction))
    assert trajectory.complete, trajectory.attributes["status"]
    return np.stack([trajectory.time, trajectory["body/velocity"][:, :2] @ direction])


def deceleration(lost: Losses, direction: tuple[float, float]) -> float:
    """Mean over 0.3 s of coasting, m/s^2."""
    time, speed = run(lost, direction, SPEED, False)
    return float((speed[0] - speed[-1]) / (time[-1] - time[0]))


def full_power(lost: Losses, friction: str) -> tuple[float, float]:
    """Speeds ahead and aside at full power, m/s: means of the last half second."""
    return tuple(  # type: ignore[return-value]
        float(run(lost, direction, 0.8 * FREE * RADIUS, True, friction)[1, -25:].mean())
        for direction in (ALONG, ACROSS)
    )


def table() -> str:
    """Rows by what makes coasting aside dearer than ahead: rolling resistance, half of both, bearings."""
    lines = [
        "| rolling resistance, mm | torque of a roller's bearing, N mm | of an axle, N m | ahead, m/s^2 | aside, m/s^2 |"
        " speed aside by ahead at full power | the same with creep |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for part in (1.0, 0.5, 0.0):
        lost = losses(part)
        slowed = [deceleration(lost, direction) for direction in (ALONG, ACROSS)]
        ratios = [aside_ / ahead for ahead, aside_ in (full_power(lost, law) for law in (COULOMB, BRUSH))]
        numbers = (1e3 * lost.resistance, 1e3 * lost.bearing, lost.axle, *slowed, *ratios)
        lines.append(f"| {' | '.join(f'{number:.3g}' for number in numbers)} |")
    return "\n".join(lines) + "\n"


def page() -> str:
    """The page with a new table."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    return before + BEGIN + table() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
