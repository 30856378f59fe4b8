"""The scene file as frozen models: its keys, their defaults and bounds.

Values keep the units of the file (SI, degrees where a key ends in `_deg`). The text that says what a key may be is the
`description` of its field and stands nowhere else. Rules across keys stand in rules.py, the messages in problems.py.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, model_validator

from omnisim.scene.drive_schema import Drive
from omnisim.scene.ground_schema import Floor, Rocker, Suspension
from omnisim.scene.values import (
    Boolean,
    Inertia,
    Name,
    NonNegative,
    Planar,
    Point,
    Positive,
    PositiveOrNone,
    Rates,
    Real,
    RealOrNone,
    Reals,
    Size,
    Table,
    Twists,
    Vectors,
    choice,
)
from omnisim.scene.wheel_schema import WheelType

GRID_TOLERANCE = 1e-9  # relative, for ratios of times that must be integers
INTERVALS = 100  # of output, about, where the scene gives no output_interval


# Which keys a friction law reads; the values that some of them have when absent.
FRICTION_KEYS = {
    "regularized": ("coefficient", "slip_speed"),
    "saturated": ("coefficient", "slip_speed"),
    "coulomb": ("coefficient",),
    "brush": ("coefficient", "slip_speed", "creep_stiffness"),
    "viscous": ("viscosity",),
    "none": (),
}
FRICTION_DEFAULTS = {"saturated": {"slip_speed": 1e-6}}


if TYPE_CHECKING:  # to a type checker a word is a word
    Upright = str
    Method = str
    Tracking = str
    Formulation = str
    Law = str
    ContactTorque = str
    Frame = str
else:
    Upright = choice("servo", "contacts", "free")
    Method = choice("heun", "rk4", "dopri5", "bs5", "radau5", "auto")
    Tracking = choice("explicit", "implicit")
    Formulation = choice("reduced", "multibody")
    Law = choice(*FRICTION_KEYS)
    ContactTorque = choice("none", "contensou")
    Frame = choice("world", "body")


class World(Table):
    """[scene]: gravity in m/s^2, and what carries roll and pitch."""

    gravity: NonNegative = 9.81
    upright: Upright = None  # type: ignore[assignment]  # see Config.upright


class Time(Table):
    """[time]: end and fixed step (s), and the grid of output that follows from them.

    step: None where [solver] has an error to pick it for; the grid of output is then all there is.
    """

    end: Positive
    step: PositiveOrNone = None
    interval: PositiveOrNone = Field(None, alias="output_interval")  # None: chosen below

    @property
    def steps_per_output(self) -> int:
        """Steps of one output interval; by default a divisor of all steps that leaves about 100 intervals."""
        if self.interval is not None:
            return round(self.interval / self._known_step)
        steps = round(self.end / self._known_step)
        return steps // _about(INTERVALS, steps)

    @property
    def _known_step(self) -> float:
        if self.step is None:
            raise ValueError("the step is still to be picked")
        return self.step

    @property
    def output_interval(self) -> float:
        """Time between two rows of output, s."""
        if self.interval is not None:
            return self.interval
        return self.end / INTERVALS if self.step is None else self.steps_per_output * self.step

    @property
    def outputs(self) -> int:
        """Number of output intervals: one less than rows."""
        return round(self.end / self.output_interval)

    @property
    def steps(self) -> int:
        """Number of steps of the whole run."""
        return self.outputs * self.steps_per_output


class Solver(Table):
    """[solver]: Runge-Kutta method, which of the two contact tracking algorithms runs, formulation of the equations of
    motion, and the error that is allowed.

    error: of position (m), yaw and spin angles (rad) in any row of output; a step is picked for it, and that of [time]
    is not used. None: no step is picked.
    """

    method: Method = "rk4"
    tracking: Tracking = "explicit"
    formulation: Formulation = "reduced"
    error: PositiveOrNone = None


class Friction(Table):
    """[friction]: a law, and the numbers it reads (slip_speed in m/s, viscosity in N s/m; 0 where absent).

    creep_stiffness: force of rubber that creeps, by load, by ratio of its slip to the speed with which it rolls.

    contact_torque adds friction of the contact patch, of patch_radius (m), against turning about the normal.
    """

    law: Law
    coefficient: NonNegative = 0.0
    slip_speed: Positive = 0.0
    creep_stiffness: Positive = 0.0
    viscosity: NonNegative = 0.0
    contact_torque: ContactTorque = "none"
    patch_radius: Positive = 0.0

    @model_validator(mode="before")
    @classmethod
    def _defaults_of_the_law(cls, data: Any) -> Any:
        law = data.get("law") if isinstance(data, dict) else None
        return FRICTION_DEFAULTS.get(law, {}) | data if isinstance(law, str) else data


# Inertia and centre of mass of a chassis that a scene leaves out are 0 here only until estimates.py has made them of
# its box, as masses and inertias of wheels are; `model_fields_set` keeps what was given.


class Chassis(Table):
    """[chassis]: mass (kg), centre of mass (m, z above the floor), inertia about it along chassis axes (kg m^2).

    What is left out is that of a box: its middle, above the origin, and its inertia about its own middle, wherever the
    centre of mass is. size = [length, width, height] is along x, y, z (m); ground_clearance (m) lies between it and the
    floor.
    """

    mass: Positive
    center_of_mass: Point = (0.0, 0.0, 0.0)
    inertia: Inertia = (0.0, 0.0, 0.0)
    size: Size = (0.0, 0.0, 0.0)
    ground_clearance: NonNegative = 0.0


class Wheel(Table):
    """[[wheels]]: a wheel type put somewhere, its start, its drive and its suspension (angles in deg, rates in
    rad/s)."""

    name: Name
    type: Annotated[str, Field(description="the name of a wheel type")]
    position: Planar = (0.0, 0.0)
    heading_deg: Real = 0.0
    mirrored: Boolean = False
    phase_deg: Real = 0.0
    spin_angle_deg: Real = 0.0
    spin_rate: Real = 0.0
    roller_rates: Rates = 0.0
    drive: Drive = Drive(kind="free")
    suspension: Suspension | None = None

    @property
    def spin_angle(self) -> float:
        """At t = 0, rad: where a table of angles begins, if the drive follows one."""
        return self.drive.angle[0] if self.drive.kind == "follow" else math.radians(self.spin_angle_deg)


class Wrench(Table):
    """[wrench]: force (N) and yaw torque (N m) on the body, linear between `times` (s)."""

    frame: Frame = "world"
    times: Reals = ()
    force: Vectors = ()
    yaw_torque: Reals = ()

    @property
    def table(self) -> tuple[tuple[float, ...], tuple[tuple[float, float, float], ...], tuple[float, ...]]:
        """Times, forces and yaw torques, equally long; zeros where the scene has none."""
        times = self.times or (0.0,)
        return times, self.force or ((0.0, 0.0, 0.0),) * len(times), self.yaw_torque or (0.0,) * len(times)


class Command(Table):
    """[command]: twist [vx, vy, yaw_rate] (m/s, m/s, rad/s) of the chassis origin in its axes, linear between `times`.

    It gives a target to every rate drive and controlled motor that has none of its own: the rate of an ideal wheel in
    this motion.
    """

    times: Reals
    twist: Twists


class Output(Table):
    """[output]: what is written beside the motion. bearing_loads: force and moment of every bearing."""

    bearing_loads: Boolean = False


class Initial(Table):
    """[initial]: position (m), yaw (deg), velocity (m/s, world) and yaw rate (rad/s) at t = 0.

    Of a machine free in space also the height of its origin over the base plane (m), pitch and roll (deg; it is turned
    by yaw, then pitch, then roll), their rates (rad/s) and the velocity along z (m/s). Without any of height, pitch and
    roll it begins at rest on the ground, in static equilibrium.
    """

    position: Planar = (0.0, 0.0)
    yaw_deg: Real = 0.0
    velocity: Planar = (0.0, 0.0)
    yaw_rate: Real = 0.0
    height: RealOrNone = None
    pitch_deg: Real = 0.0
    roll_deg: Real = 0.0
    vertical_velocity: Real = 0.0
    pitch_rate: Real = 0.0
    roll_rate: Real = 0.0

    @property
    def placed(self) -> bool:
        """Whether the scene says how high or how inclined a machine free in space begins."""
        return not self.model_fields_set.isdisjoint(("height", "pitch_deg", "roll_deg"))


class Config(Table):
    """A whole scene file. Made by `validate`, which also checks the rules across keys."""

    schema_version: Annotated[int, Field(ge=1, le=1, alias="schema", description="1")]
    title: Annotated[str, Field(pattern=r"^[\t\n\P{Cc}]*$", description="a string without control characters")] = ""
    world: World = Field(World(), alias="scene")
    floor: Floor = Floor()
    time: Time
    solver: Solver = Solver()
    friction: Friction
    wheel_types: Annotated[
        dict[Name, WheelType], Field(min_length=1, description="one or more tables [wheel_types.NAME]")
    ]
    chassis: Chassis | None = None
    wheels: Annotated[tuple[Wheel, ...], Field(min_length=1, description="one or more tables [[wheels]]")]
    axles: tuple[Rocker, ...] = ()
    command: Command | None = None
    wrench: Wrench = Wrench()
    initial: Initial = Initial()
    output: Output = Output()

    @property
    def upright(self) -> str:
        """What carries roll and pitch: "servo", "contacts", or "free": nothing."""
        return self.world.upright or ("contacts" if self.chassis else "servo")

    @property
    def bearing_loads(self) -> bool:
        """Whether what bearings carry is written; multipliers of the multibody formulation are there anyway."""
        return self.output.bearing_loads or self.solver.formulation == "multibody"

    def type_of(self, wheel: Wheel) -> WheelType:
        return self.wheel_types[wheel.type]

    def rocker_of(self, wheel: Wheel) -> Rocker | None:
        """The rocker on which a wheel stands."""
        return next((axle for axle in self.axles if wheel.name in axle.wheels), None)

    @property
    def sample_times(self) -> tuple[float, ...]:
        """Of the controllers that have one, s."""
        return tuple(wheel.drive.sample_time for wheel in self.wheels if wheel.drive.sample_time is not None)

    def suits(self, step: float) -> bool:
        """Whether the output interval and all sample times are multiples of a step (s)."""
        return all(is_whole(time / step) for time in (self.time.output_interval, *self.sample_times))

    def at_step(self, step: float) -> "Config":
        """The same scene and rows, marched with this step (s) instead of one picked for an error."""
        time = self.time.model_copy(update={"step": step, "interval": self.time.output_interval})
        return self.model_copy(update={"time": time, "solver": self.solver.model_copy(update={"error": None})})


def unused_keys(config: Config) -> tuple[str, ...]:
    """Dotted keys that nothing reads: those of other friction laws, shapes beside the numbers that they would give,
    wheel types without a wheel."""
    friction = config.friction.model_fields_set - {"law", *FRICTION_KEYS[config.friction.law]}
    friction -= {"contact_torque"} | ({"patch_radius"} if config.friction.contact_torque != "none" else set())
    types = set(config.wheel_types) - {wheel.type for wheel in config.wheels}
    densities = {
        f"{name}.roller.density"
        for name, kind in config.wheel_types.items()
        if {"mass", "density"} <= kind.roller.model_fields_set
    }
    chassis = config.chassis.model_fields_set if config.chassis else set()
    read = "size" in chassis and (config.upright == "free" or "center_of_mass" not in chassis)
    clearance = set() if read else chassis & {"ground_clearance"}
    unread = (("friction", friction), ("wheel_types", types | densities), ("chassis", clearance))
    return tuple(f"{table}.{key}" for table, keys in unread for key in sorted(keys))


@lru_cache(maxsize=16)
def _about(wanted: int, steps: int) -> int:
    """The divisor of `steps` nearest to `wanted`; a row too many is better than one too few, which counts double."""
    small = [d for d in range(1, math.isqrt(steps) + 1) if steps % d == 0]
    return min((*small, *(steps // d for d in small)), key=lambda d: max(d / wanted, (wanted / d) ** 2))


def is_whole(ratio: float) -> bool:
    """Whether a ratio of times is an integer > 0, as far as decimals can say it."""
    return math.isfinite(ratio) and ratio > 0.5 and abs(ratio - round(ratio)) <= GRID_TOLERANCE * ratio
