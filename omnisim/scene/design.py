"""A robot from the few numbers of its data sheet: rollers that fit, masses, gains, a square to drive."""

import math
from typing import NamedTuple

from omnisim.scene.solids import Outline, gap, hub_radius, ring_half_width, solid

ROLLER_DENSITY, DISK_DENSITY = 1200.0, 1400.0  # kg/m^3: rubber on plastic; aluminium with holes
BORE = 0.3  # of the roller's radius amid
HUB = 0.9  # of the radius that rollers leave free
THICKEST = 0.2  # of the wheel radius: a roller amid, where it is not given
TIP = 0.02  # of the wheel radius: how far rollers stay from pointed tips
LARGEST_WHEEL = 2.0  # m, radius
ROOM, LEAST_HUB = 0.01, 0.3  # of the wheel radius: between rollers, and for the hub
SETTLING, RESETTING = 0.02, 0.1  # s: how fast a controller follows, and how fast its integral does
MOST_ROLLERS = 100  # that are tried for what would fit
HALVINGS = 30  # of a distance that just fits: to 1e-9 of it
GRAVITY = 9.81  # m/s^2
FRICTION = 0.6  # of rubber on a hard floor
EASY = 0.5  # of what drives and floor can give: how hard the command accelerates
GRID = 0.05  # s, of the command


class DesignError(ValueError):
    """Why no machine can be made of these numbers, and what would."""


class Kind(NamedTuple):
    """What wheels a kind of machine has: their name, roller angle (deg), usual number of rollers, rows of these."""

    told: str
    wheel: str
    psi_deg: float
    rollers: int
    rows: int


KINDS = {
    "mecanum": Kind("four mecanum wheels, one at each corner", "mecanum", 45.0, 10, 1),
    "kiwi": Kind("three omni wheels around the middle", "omni", 0.0, 18, 2),
    "four-omni": Kind("four omni wheels, one at each corner, rolling around the middle", "omni", 0.0, 18, 2),
}


class Controller(NamedTuple):
    """A drive that follows its rate with at most this torque at the wheel, N m."""

    torque: float

    @property
    def most_torque(self) -> float:
        return self.torque

    @property
    def most_rate(self) -> float:
        return math.inf

    def drive(self, inertia: float) -> str:
        """The table of a wheel; inertia: of the machine as one wheel feels it, kg m^2."""
        gain = inertia / SETTLING
        gains = f"proportional = {short(gain)}, integral = {short(gain / RESETTING)}"
        return f'drive = {{ kind = "rate", {gains}, torque_limit = {short(self.torque)} }}'


class Motor(NamedTuple):
    """A motor by its data sheet, before its gear: torques (N m), currents (A), speed (rad/s), voltage (V)."""

    stall_torque: float
    stall_current: float
    no_load_speed: float
    no_load_current: float
    nominal_voltage: float
    gear_ratio: float = 1.0

    @property
    def most_torque(self) -> float:
        return self.gear_ratio * self.stall_torque

    @property
    def most_rate(self) -> float:
        return self.no_load_speed / self.gear_ratio

    def drive(self, inertia: float) -> str:
        """The table of a wheel: a controller with at least the gain of the motor's own back-EMF, and the data sheet."""
        back = self.nominal_voltage / self.most_rate
        gain = max(inertia * self.nominal_voltage / self.stall_current / back / SETTLING, back)
        units = ("N m", "A", "rad/s", "A", "V", "motor to wheel")
        sheet = (
            f"{key} = {short(value)} # {unit}" for (key, value), unit in zip(self._asdict().items(), units, strict=True)
        )
        gains = f"proportional = {short(gain)} # V s/rad", f"integral = {short(gain / RESETTING)} # V/rad"
        return "\n".join(["[wheels.drive]", 'kind = "dc_motor"', *gains, *sheet])


class Robot(NamedTuple):
    """What a data sheet says (m, kg, m/s). Places of the wheels: track and wheelbase, or of a kiwi the distance of each
    from the middle. wheel: the name of a packaged one, whose radius is wheel_radius. None: estimated."""

    kind: str
    wheel_radius: float
    mass: float
    motor: Controller | Motor
    track: float = 0.0
    wheelbase: float = 0.0
    distance: float = 0.0
    rollers: int | None = None
    roller_diameter: float | None = None
    wheel_mass: float | None = None
    size: tuple[float, float, float] | None = None
    friction: float | None = None
    speed: float | None = None
    side: float = 1.0
    wheel: str | None = None


class Wheel(NamedTuple):
    """A wheel on the machine: place (m), heading (deg), hand."""

    name: str
    x: float
    y: float
    heading: float
    mirrored: bool = False


class Part(NamedTuple):
    """The wheel type: number and distance of rollers, size of hub (m), masses (kg)."""

    shape: Outline
    rollers: int
    bore: float
    roller_mass: float
    hub: float
    width: float
    disk_mass: float

    @property
    def mass(self) -> float:
        return self.disk_mass + self.rollers * self.roller_mass


def wheels(robot: Robot) -> list[Wheel]:
    """Where they stand and where they roll."""
    if robot.kind == "kiwi":
        names, angles = ("left", "back", "right"), (60.0, 180.0, 300.0)
        return [_around(name, robot.distance, angle) for name, angle in zip(names, angles, strict=True)]
    x, y = 0.5 * robot.wheelbase, 0.5 * robot.track
    corners = (("front_left", x, y), ("front_right", x, -y), ("rear_left", -x, y), ("rear_right", -x, -y))
    if robot.kind == "mecanum":
        return [Wheel(name, x, y, 0.0, mirrored=x * y < 0.0) for name, x, y in corners]
    return [Wheel(name, x, y, (math.degrees(math.atan2(y, x)) + 90.0) % 360.0) for name, x, y in corners]


def _around(name: str, distance: float, angle: float) -> Wheel:
    x, y = distance * math.cos(math.radians(angle)), distance * math.sin(math.radians(angle))
    return Wheel(name, x, y, (angle + 90.0) % 360.0)


# --- the wheel ------------------------------------------------------------------------------------


def part(robot: Robot) -> Part:
    """The wheel of a robot, or DesignError if its rollers do not fit or weigh too much."""
    kind = KINDS[robot.kind]
    radius = robot.wheel_radius
    if radius > LARGEST_WHEEL:
        raise DesignError(f"a wheel of {radius:g} m; a number without a unit is in metres: {radius:g}mm?")
    count = robot.rollers or kind.rollers
    shape = _outline(radius, kind, count, _distance(robot, kind, count))
    bore = BORE * (radius - shape.roller_distance)
    hub = HUB * hub_radius(shape)
    width = 2.0 * ring_half_width(shape)
    roller = ROLLER_DENSITY * solid(shape, bore).volume
    disk = DISK_DENSITY * math.pi * hub**2 * width if robot.wheel_mass is None else robot.wheel_mass - count * roller
    if disk <= 0.0:
        heavy = f"{count} rollers alone weigh {count * roller:.3g} kg at {ROLLER_DENSITY:g} kg/m^3"
        raise DesignError(f"a wheel of {robot.wheel_mass:g} kg is too light: {heavy}")
    return Part(shape, count, bore, roller, hub, width, disk)


def _outline(radius: float, kind: Kind, count: int, distance: float) -> Outline:
    psi = math.radians(kind.psi_deg)
    return Outline(radius, distance, math.pi / count, math.cos(psi), math.sin(psi))


def _distance(robot: Robot, kind: Kind, count: int) -> float:
    """From the wheel's centre to its rollers', m: that of the rollers given, or of the thickest usual ones that fit."""
    radius = robot.wheel_radius
    nearest, farthest = _limits(radius, kind, count)
    if nearest > farthest:
        fitting = [n for n in range(4, MOST_ROLLERS + 1) if _limits(radius, kind, n)[0] <= _limits(radius, kind, n)[1]]
        raise DesignError(f"{count} rollers do not fit on this wheel; {fitting[0]} to {fitting[-1]} do")
    if robot.roller_diameter is None:
        return round(min(max(nearest, (1.0 - THICKEST) * radius), farthest), 6)
    distance = radius - 0.5 * robot.roller_diameter
    if not nearest <= distance <= farthest:
        thin, thick = 2.0 * (radius - farthest), 2.0 * (radius - nearest)
        others = f"diameters from {1e3 * thin:.3g} to {1e3 * thick:.3g} mm do"
        raise DesignError(f"{count} rollers of {1e3 * robot.roller_diameter:g} mm do not fit on this wheel; {others}")
    return distance


def _limits(radius: float, kind: Kind, count: int) -> tuple[float, float]:
    """Distances (m) between which neighbours and the hub have room, and tips are not pointed; no such if they cross."""
    farthest = radius * (math.cos(math.pi / count) - TIP)
    low, high = 0.5 * (1.0 + LEAST_HUB) * radius, farthest

    def fits(distance: float) -> bool:
        return gap(_outline(radius, kind, count, distance), kind.rows) >= ROOM * radius

    if high <= low or not fits(high):
        return math.inf, farthest
    if fits(low):
        return low, farthest
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high, farthest


# --- the motion -----------------------------------------------------------------------------------


class Square(NamedTuple):
    """Times (s) and speeds (m/s) of one side, from rest to rest."""

    ramp: float
    side: float
    speed: float

    @property
    def leg(self) -> float:
        return self.side + self.ramp


def square(robot: Robot, friction: float) -> Square:
    """A side at about the speed asked for, at half of what drives and floor can give."""
    radius = robot.wheel_radius
    speed = robot.speed or min(0.5, 0.5 * robot.motor.most_rate * radius)
    pull = min(2.0 * robot.motor.most_torque / radius / robot.mass, 0.5 * friction * GRAVITY)  # of two wheels at least
    side = GRID * max(1, math.ceil(robot.side / speed / GRID))
    ramp = GRID * max(2, math.ceil(robot.side / side / (EASY * pull) / GRID))
    if ramp > side:
        far = f"it takes {ramp:.3g} s to reach {speed:g} m/s, and a side of {robot.side:g} m {side:.3g} s"
        raise DesignError(f"the motors are too weak for this speed: {far}; a lower speed or a longer side will do")
    return Square(ramp, side, robot.side / side)


def short(value: float) -> str:
    """Up to six digits, as a TOML float; rounding errors of places are 0."""
    text = f"{round(value, 12) + 0.0:.6g}"
    return text if set(text) & set(".e") else f"{text}.0"
