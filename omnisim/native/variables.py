"""What goes into a machine and comes out of it: variables by name, each with where it stands in the memory.

Outputs have the names, units and meanings of columns of a trajectory's table: body/position.x, wheels/left/spin_rate.
"""

from collections.abc import Iterator
from typing import NamedTuple

from omnisim.base.status import EVENT_KINDS
from omnisim.dynamics.input_tables import WRENCH
from omnisim.dynamics.parameters import DRIVE_INPUT
from omnisim.dynamics.state import YAW, Places, places_in
from omnisim.native.memory import Machine, Memory
from omnisim.results.layout import LABELS, layout
from omnisim.scene.drive_schema import Drive
from omnisim.scene.schema import Config

STATE, SEEN, SEEN_WHOLE, BODY, EVENT = range(5)  # where an output is found, see machine.c
DRIVEN = {  # what a drive is given: unit, meaning
    "torque": ("N m", "torque that the drive is asked for"),
    "rate": ("rad/s", "spin rate that the drive follows"),
    "voltage": ("V", "voltage that the motor is asked for"),
}
PUSHED = {  # the wrench, in the order of its channels
    "force.x": ("N", "external force along x of wrench.frame"),
    "force.y": ("N", "external force along y of wrench.frame"),
    "force.z": ("N", "external force along z"),
    "yaw_torque": ("N m", "external torque about z"),
}
# Of the body, in the order in which machine.c finds them: upright, and free in space.
UPRIGHT = (*(f"body/position.{axis}" for axis in "xyz"), *(f"body/velocity.{axis}" for axis in "xyz"), "odometry/yaw")
FREE = (
    *UPRIGHT,
    *(f"body/angular_velocity.{axis}" for axis in "xyz"),
    *(f"body/orientation.{part}" for part in "wxyz"),
)
WHEEL = {  # fields of OBSERVED_WHEEL by dataset of a wheel
    "drive_torque": "drive_torque",
    "normal_force": "normal_force",
    "slip_velocity": "slip_velocity",
    "friction_force": "friction_force",
    "contact_roller": "roller",
    "contact_share": "share",
    "contact_torque": "contact_torque",
}
MOTOR = {"voltage": "voltage", "current": "current"}


class Input(NamedTuple):
    """channel: of the tables. start: what the scene gives at t = 0."""

    name: str
    unit: str
    description: str
    channel: int
    start: float


class Output(NamedTuple):
    """found: STATE and so on. place: in the memory, bytes; of BODY and EVENT, which of them."""

    name: str
    unit: str
    description: str
    found: int
    place: int

    @property
    def whole(self) -> bool:
        """Whether it is a whole number."""
        return self.found in (SEEN_WHOLE, EVENT)


def takes_input(drive: Drive) -> bool:
    """Whether a drive can be given something from outside: one that follows angles cannot."""
    return drive.given is not None and drive.kind != "follow"


def inputs_of(config: Config, machine: Machine) -> list[Input]:
    """Those of the drives, then the wrench."""
    starts = machine.parameters.inputs[0, :, 0]
    found = []
    for w, wheel in enumerate(config.wheels):
        if takes_input(wheel.drive):
            given = str(wheel.drive.given)
            channel = DRIVE_INPUT + w
            found.append(Input(f"wheels/{wheel.name}/{given}", *DRIVEN[given], channel, float(starts[channel])))
    wrench = zip(PUSHED.items(), WRENCH, strict=True)
    return found + [Input(f"wrench/{name}", *told, at, float(starts[at])) for (name, told), at in wrench]


def outputs_of(config: Config, machine: Machine, memory: Memory) -> list[Output]:
    """Pose and twist, odometry, wheels, events."""
    table = layout(tuple(wheel.name for wheel in config.wheels))
    found = []
    for name, where, place in places(config, machine, memory):
        quantity = table[name.partition(".")[0]]
        label = f", {name.partition('.')[2]}" * ("." in name)
        found.append(Output(name, quantity.units, quantity.description + label, where, place))
    return found + [
        Output(f"events/{kind}", "1", f"events of the kind {kind} so far", EVENT, i)
        for i, kind in enumerate(EVENT_KINDS)
    ]


def places(config: Config, machine: Machine, memory: Memory) -> Iterator[tuple[str, int, int]]:
    """Names but those of events, with where each is found."""
    parameters, _, run, *_ = machine.marched
    at: Places = places_in(parameters)
    free = parameters.space is not None
    there = [name for name in (FREE if free else UPRIGHT) if parameters.machine.odometry or "odometry" not in name]
    yield from ((name, BODY, (FREE if free else UPRIGHT).index(name)) for name in there)
    if not free:
        yield "body/yaw", STATE, memory.element(run.y, YAW)
        yield "body/yaw_rate", STATE, memory.element(run.y, at.yaw_rate)
    if parameters.machine.odometry:
        yield "odometry/position.x", STATE, memory.element(run.y, at.odometry)
        yield "odometry/position.y", STATE, memory.element(run.y, at.odometry + 1)
    seen = machine.observed[-1].wheels
    for w, wheel in enumerate(config.wheels):
        folder = f"wheels/{wheel.name}"
        yield f"{folder}/spin_angle", STATE, memory.element(run.y, at.spin_angle + w)
        yield f"{folder}/spin_rate", STATE, memory.element(run.y, at.spin_rate + w)
        for name, field in (WHEEL | (MOTOR if wheel.drive.kind == "dc_motor" else {})).items():
            place = memory.field(seen, field, 0, w)
            kind = seen.dtype[field]
            if kind.shape:
                for i, label in enumerate(LABELS["tangent"]):
                    yield f"{folder}/{name}.{label}", SEEN, place + i * kind.base.itemsize
            else:
                yield f"{folder}/{name}", SEEN_WHOLE if kind.kind == "i" else SEEN, place
