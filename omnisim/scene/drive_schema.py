"""The drive of a wheel in a scene file: its kinds, and which keys each of them reads."""

import math
from typing import TYPE_CHECKING, NamedTuple

from omnisim.scene.values import NonNegative, Positive, PositiveOrNone, Reals, Table, Tabulated, choice

# Two ways to say what a motor is, and what only a controller of its rate reads.
MOTOR_CONSTANTS = ("resistance", "torque_constant", "viscosity", "friction_torque")
DATA_SHEET = ("stall_torque", "stall_current", "no_load_speed", "no_load_current", "nominal_voltage")
CONTROLLER = ("proportional", "rate", "integral", "derivative", "sample_time")


class DriveKeys(NamedTuple):
    """What a drive reads: the keys that are a number or a list over `times`, the keys it needs, those with defaults."""

    given: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()

    @property
    def all(self) -> set[str]:
        return {"times", *self.given, *self.needed, *self.optional} if self.given else set()


DRIVE_KEYS = {
    "free": DriveKeys(),
    "torque": DriveKeys(("torque",), needed=("torque",)),
    "follow": DriveKeys(("angle",), needed=("times", "angle")),
    "rate": DriveKeys(("rate",), needed=("proportional",), optional=("integral", "torque_limit")),
    "dc_motor": DriveKeys(
        ("voltage", "rate"),
        optional=(
            *CONTROLLER, "voltage_limit", "current_limit", *MOTOR_CONSTANTS, *DATA_SHEET, "gear_ratio", "inductance",
            "rotor_inertia", "friction_rate",
        ),
    ),
}  # fmt: skip

if TYPE_CHECKING:  # to a type checker a word is a word
    Kind = str
else:
    Kind = choice(*DRIVE_KEYS)


class Drive(Table):
    """drive of a wheel: what turns it about its axle. The kind says which keys it reads.

    free      nothing
    torque    a torque (N m)
    follow    angles (rad) at `times` (s): it turns the wheel exactly as a cubic through them does, whatever torque that
              takes; the cubic begins with the wheel's spin rate, and ends without acceleration
    rate      a controller of the spin rate: a target (rad/s; absent: that of [command]), proportional gain (N m s/rad),
              integral gain (N m/rad), and the largest torque (N m)
    dc_motor  a voltage (V), or a controller that gives it to follow a target rate as above: proportional gain
              (V s/rad), integral gain (V/rad), derivative gain (V s^2/rad); the largest voltage (V) and current (A);
              the motor: resistance (ohm), inductance (H), torque constant (N m/A, which is V s/rad too), gear ratio,
              inertia of the rotor itself (kg m^2); friction at the wheel: viscosity (N m s), and a Coulomb torque (N m)
              that changes its sign over a rate (rad/s)

    Torque, target and voltage are constant, or linear between `times` (s).

    With a sample time (s) the controller reads the spin rate at multiples of it, and holds its voltage between them;
    only then has it a derivative gain, on the change of the measured rate.

    Instead of resistance, torque constant and friction a motor may have the values of its data sheet, all before the
    gear: torque (N m) and current (A) at standstill, speed (rad/s) and current (A) without load, each at the nominal
    voltage (V), which is then the largest voltage of a controller that has no other.
    """

    kind: Kind
    times: Reals = ()
    torque: Tabulated = 0.0
    angle: Reals = ()
    rate: Tabulated = None  # type: ignore[assignment]  # where [command] gives it
    proportional: Positive = 0.0
    integral: NonNegative = 0.0
    derivative: NonNegative = 0.0
    sample_time: PositiveOrNone = None
    torque_limit: Positive = math.inf
    voltage_limit: Positive = math.inf
    current_limit: Positive = math.inf
    voltage: Tabulated = 0.0
    resistance: Positive = 0.0
    torque_constant: Positive = 0.0
    gear_ratio: Positive = 1.0
    inductance: NonNegative = 0.0
    rotor_inertia: NonNegative = 0.0
    viscosity: NonNegative = 0.0
    friction_torque: NonNegative = 0.0
    friction_rate: Positive = 0.1

    stall_torque: PositiveOrNone = None
    stall_current: PositiveOrNone = None
    no_load_speed: PositiveOrNone = None
    no_load_current: NonNegative = 0.0
    nominal_voltage: PositiveOrNone = None

    @property
    def controlled(self) -> bool:
        """Whether it follows a spin rate."""
        return self.kind == "rate" or (self.kind == "dc_motor" and self.proportional > 0.0)

    @property
    def follows_command(self) -> bool:
        return self.controlled and self.rate is None

    @property
    def given(self) -> str | None:
        """The key that is a number or a list over `times`; None: it takes no input."""
        return "rate" if self.controlled else next(iter(DRIVE_KEYS[self.kind].given), None)

    @property
    def table(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Times, and torques, angles, target rates or voltages; 0 where nothing is given or [command] gives it.

        A constant is a table of one point, since tables are held outside.
        """
        given = self.given
        if given is None or self.follows_command:
            return (0.0,), (0.0,)
        values = getattr(self, given)
        return (self.times, values) if self.times else ((0.0,), (values,))
