"""How a mecanum machine coasts: which rolling resistance and bearing friction its deceleration tells of, and what they
cost at full power.

    python -m docs.coast_down           writes its tables in docs/pages/rolling.md anew

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
BEGIN_SPEED = "<!-- python -m docs.coast_down, full power -->\n"
G = 9.81
ALONG, ACROSS = (1.0, 0.0), (0.0, 1.0)
AHEAD, ASIDE = 0.90, 1.82  # m/s^2
STRAFING = 0.73  # speed aside by that ahead
MASS = 13.0  # kg, of all
RADIUS, DISTANCE, ROLLERS = 0.048, 0.0385, 9
WHEEL_MASS, SPEED = 0.35, 1.2  # kg; m/s from which it coasts
INERTIA = 4.0e-4  # kg m^2, of a wheel with its rollers about its axle
EFFECTIVE = MASS + 4.0 * INERTIA / RADIUS**2  # kg
DISK = "{ mass = 0.17, inertia_axle = 1.2e-4, inertia_diameter = 7e-5 }"
ROLLER = "mass = 0.02, inertia_axial = 8e-7, inertia_transverse = 3e-6"
FREE, VOLTAGE, STALL_CURRENT = 32.7, 12.0, 9.2  # rad/s, V, A: a gear motor of 312 rpm, as are sold for such machines
GRIP = 0.9  # coefficient of friction
SOFTEST = 3.0 * GRIP  # creep stiffness at which rubber slides only where it no longer rolls
COULOMB = f'{{ law = "coulomb", coefficient = {GRIP} }}'
CREEP = 12.0  # of rubber: force by load, by slip


class Losses(NamedTuple):
    """f of rollers (m), Coulomb torque of their bearings and of each axle (N m)."""

    resistance: float
    bearing: float
    axle: float


class Motor(NamedTuple):
    """Torque at stall (N m) and speed without load (rad/s) of a wheel: its torque falls straight from one to the other."""

    stall: float = 2.4
    free: float = FREE


# Creep stiffness, motor, and supply (ohm) in the middle of what is usual, and at the poor end. ASSUMED
TOGETHER = {"middling": (20.0, Motor(stall=1.8), 0.12), "poor": (10.0, Motor(stall=1.2), 0.2)}


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


def brush(stiffness: float) -> str:
    """Friction of rubber that creeps."""
    return f'{{ law = "brush", coefficient = {GRIP}, creep_stiffness = {stiffness}, slip_speed = 2e-3 }}'


def scene(
    lost: Losses, direction: tuple[float, float], speed: float, motor: Motor | None, friction: str
) -> omnisim.Scene:
    """A machine on four 45 deg wheels that begins to roll with this speed (m/s): full power on its motors, or none: it
    coasts, its axles braked."""
    wheels = []
    for x, y in ((0.2, 0.18), (0.2, -0.18), (-0.2, 0.18), (-0.2, -0.18)):
        mirrored = x * y < 0.0
        sense = direction[0] + (direction[1] if mirrored else -direction[1])
        drive = f'kind = "torque", torque = {-sense * lost.axle}'
        if motor:
            rate, slope = motor.free * (1.0 - lost.axle / motor.stall), motor.stall / motor.free
            drive = f'kind = "rate", rate = {sense * rate}, proportional = {slope}'
        wheels.append(
            f'{{ name = "w{len(wheels)}", type = "mecanum", position = [{x}, {y}], mirrored = {str(mirrored).lower()}, '
            f"spin_rate = {sense * speed / RADIUS}, roller_rates = {direction[1] * speed * aside().joint}, "
            f"drive = {{ {drive} }} }}"
        )
    roller = f"{ROLLER}, rolling_resistance = {lost.resistance}, bearing_torque = {lost.bearing}"
    return parse(f"""
schema = 1
scene = {{ upright = "servo" }}
time = {{ end = {2.0 if motor else 0.3}, step = 1e-3, output_interval = 0.02 }}
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
    lost: Losses, direction: tuple[float, float], speed: float, motor: Motor | None, friction: str = COULOMB
) -> np.ndarray:
    """Times (s) and the speeds along the direction (m/s), (2, T)."""
    trajectory = omnisim.simulate(scene(lost, direction, speed, motor, friction))
    assert trajectory.complete, trajectory.attributes["status"]
    return np.stack([trajectory.time, trajectory["body/velocity"][:, :2] @ direction])


def deceleration(lost: Losses, direction: tuple[float, float], friction: str = COULOMB) -> float:
    """Mean over 0.3 s of coasting, or until a quarter of the speed is left, m/s^2."""
    time, speed = run(lost, direction, SPEED, None, friction)
    last = np.flatnonzero(speed > 0.25 * SPEED)[-1]
    return float((speed[0] - speed[last]) / (time[last] - time[0]))


def strafing(lost: Losses, motor: Motor, friction: str) -> float:
    """Speed aside by that ahead at full power: means of the last half second."""
    ahead, across = (
        float(run(lost, direction, 0.8 * motor.free * RADIUS, motor, friction)[1, -25:].mean())
        for direction in (ALONG, ACROSS)
    )
    return across / ahead


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
        ratios = [strafing(lost, Motor(), law) for law in (COULOMB, brush(CREEP))]
        numbers = (1e3 * lost.resistance, 1e3 * lost.bearing, lost.axle, *slowed, *ratios)
        lines.append(f"| {' | '.join(f'{number:.3g}' for number in numbers)} |")
    return "\n".join(lines) + "\n"


class Machine(NamedTuple):
    """What a row of the second table simulates."""

    lost: Losses
    motor: Motor = Motor()
    friction: str = COULOMB

    @property
    def numbers(self) -> tuple[float, float, float]:
        """Speed aside by that ahead at full power, decelerations ahead and aside (m/s^2)."""
        slowed = (deceleration(self.lost, direction, self.friction) for direction in (ALONG, ACROSS))
        return strafing(*self), *slowed


def stall_acceleration(motor: Motor) -> float:
    """Of the machine, by four motors at stall, m/s^2."""
    return 4.0 * motor.stall / (RADIUS * EFFECTIVE)


def behind(resistance: float, motor: Motor) -> Motor:
    """One of four motors on a supply with this resistance (ohm): to each it is four times that, since all draw as much."""
    return motor._replace(stall=motor.stall / (1.0 + 4.0 * resistance * STALL_CURRENT / VOLTAGE))


def at_voltage(volts: float) -> Motor:
    """A motor on another supply than its own: torque and speed by the voltage."""
    return Motor(Motor().stall * volts / VOLTAGE, FREE * volts / VOLTAGE)


def needed() -> dict[str, float]:
    """What each thing alone has to be for the published speed aside, by arithmetic: a motor's speed falls in proportion to
    its load, so that speeds are as 1 - deceleration / acceleration at stall; ahead the machine decelerates as published.

    resistance (m) and bearing (N m) of rollers, arms (m) of a bearing's torque by the load and by the thrust along its
    roller; stall torque of a motor (N m), resistance of the supply (ohm), its voltage (V).
    """
    stall = stall_acceleration(Motor())
    aside_ = stall - STRAFING * (stall - AHEAD)
    more = (aside_ - AHEAD) / (ASIDE - AHEAD)
    bearing = more * losses(0.0).bearing
    weak = (ASIDE - STRAFING * AHEAD) / (1.0 - STRAFING) / stall
    return {
        "resistance": more * losses(1.0).resistance,
        "bearing": bearing,
        "by load": bearing / (MASS * G / 4.0),
        "by thrust": bearing / (math.sqrt(2.0) * EFFECTIVE * aside_ / 4.0),
        "stall": weak * Motor().stall,
        "supply": (1.0 / weak - 1.0) * VOLTAGE / (4.0 * STALL_CURRENT),
        "voltage": weak * VOLTAGE,
    }


def speed_table() -> str:
    """Rows by what alone would make the published speed aside, and by poor but usual values of all."""
    need, lost = needed(), losses(1.0)
    axle = (AHEAD * EFFECTIVE - need["resistance"] * MASS * G / RADIUS) * RADIUS / 4.0
    millimetres = {key: f"{1e3 * need[key]:.2g} mm" for key in ("resistance", "by load", "by thrust")}
    arms = f"{1e3 * need['bearing']:.2g} N mm: {millimetres['by load']} of the load or {millimetres['by thrust']} of the thrust"
    rows = [
        ("nothing: as above", "", "", Machine(lost)),
        (
            "rolling resistance",
            millimetres["resistance"],
            "0.3 to 1 mm",
            Machine(Losses(need["resistance"], 0.0, axle)),
        ),
        ("bearings of rollers", arms, "0.2 to 0.4 mm", Machine(losses(0.0)._replace(bearing=need["bearing"]))),
        ("rubber that creeps", f"less than {SOFTEST:.2g}, shown", "10 to 30", Machine(lost, friction=brush(SOFTEST))),
        ("weak motors", f"{need['stall']:.2g} N m", "1.2 to 2.4 N m", Machine(lost, Motor(need["stall"]))),
        (
            "a supply that sags",
            f"{need['supply']:.2g} ohm",
            "0.05 to 0.2 ohm",
            Machine(lost, behind(need["supply"], Motor())),
        ),
        ("a low voltage", f"{need['voltage']:.2g} V", "11 to 13 V", Machine(lost, at_voltage(need["voltage"]))),
    ]
    for name, (stiffness, motor, supply) in TOGETHER.items():
        usual = f"creep {stiffness:g}, {motor.stall:g} N m, {supply:g} ohm"
        rows.append((f"all at once, each {name}", "", usual, Machine(lost, behind(supply, motor), brush(stiffness))))
    lines = [
        "| what slows aside | alone it takes | usual (assumed) | speed aside by ahead | coasting ahead, m/s^2 | aside |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for what, takes, usual, machine in rows:
        lines.append(f"| {what} | {takes} | {usual} | {' | '.join(f'{number:.3g}' for number in machine.numbers)} |")
    return "\n".join(lines) + "\n"


def page() -> str:
    """The page with new tables."""
    text = PAGE.read_text(encoding="utf-8")
    for begin, made in ((BEGIN, table()), (BEGIN_SPEED, speed_table())):
        before, _, rest = text.partition(begin)
        text = before + begin + made + END + rest.partition(END)[2]
    return text


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
