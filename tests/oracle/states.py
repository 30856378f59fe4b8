"""Rows of a run as the oracle has them: what it finds in each is held against what the run says of itself."""

import tomllib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

import omnisim
from oracle.machine import Machine, Mode, Reactions
from oracle.multibody import Turning, observe, place
from oracle.vectors import AXIS, FLAT, UP, cross


class Given(Machine):
    """The same bodies and multipliers under given forces of friction and torques of drives, whatever law they obey.

    forces (W, 3): on each wheel's roller, N, world axes; drives (W,): on each disk about its axle, N m; None: those
    of the scene.
    """

    forces: np.ndarray
    drives: np.ndarray | None = None

    def __init__(self, scene: dict) -> None:
        super().__init__(scene | {"friction": {"law": "none"}})

    def touch(self, wheel, bodies, roller):
        return super().touch(wheel, bodies, roller)._replace(free=self.forces[self.wheels.index(wheel)])

    def mode(self, time, contacts):
        mode = super().mode(time, contacts)
        if self.drives is not None:
            mode.value[: len(self.drives)], mode.slope[: len(self.drives)] = self.drives, 0.0
        return mode


class OnTwo(Machine):
    """A bare wheel on two rollers that share its load as the run says, the roller ahead first.

    Both touch straight below the centre, so that only friction tells the shares apart: with the right ones the wheel
    does not start to spin.
    """

    share: float

    def touches(self, bodies, contacts):
        (wheel,), (ahead,) = self.wheels, contacts
        touches = [self.touch(wheel, bodies, roller) for roller in (ahead, ahead - 1)]
        return [touch._replace(free=part * touch.free) for touch, part in zip(touches, self.parts, strict=True)]

    def shares(self, bodies, touches):
        return np.array(self.parts)[:, None]

    @property
    def parts(self):
        return self.share, 1.0 - self.share


class State(NamedTuple):
    """A row of a run: time (s), bodies (B, 18) of the oracle, and what it finds there, `told` as `observe` does."""

    row: int
    bodies: np.ndarray
    mode: Mode
    reactions: Reactions
    told: dict


def states(
    scene: omnisim.Scene, run: omnisim.Trajectory, kind: type[Machine], count: int
) -> Iterator[tuple[Machine, State]]:
    """Some rows of a run of `scene`, solved as free bodies that joints and the floor hold."""
    machine = kind(tomllib.loads(scene.text))
    for row in rows_of_interest(run, count):
        bodies = bodies_of(machine, run, row)
        if isinstance(machine, Given):
            machine.forces = np.array([friction(run, row, wheel.name, bodies[wheel.disk]) for wheel in machine.wheels])
            machine.drives = np.array([run[f"wheels/{wheel}/drive_torque"][row] for wheel in run.wheels])
        if isinstance(machine, OnTwo):
            machine.share = run[f"wheels/{run.wheels[0]}/contact_share"][row]
        contacts = [int(run[f"wheels/{wheel}/contact_roller"][row]) for wheel in run.wheels]
        time = float(run.time[row])
        mode = machine.mode(time, contacts)
        angles = [run[f"wheels/{wheel}/spin_angle"][row] for wheel in run.wheels]
        told = observe(machine, time, np.concatenate([bodies.ravel(), angles, run["body/yaw"][row : row + 1]]), mode)
        yield machine, State(row, bodies, mode, machine.solve(time, bodies, mode), told)


def rows_of_interest(run: omnisim.Trajectory, count: int) -> list[int]:
    """So many rows spread evenly, and the last before and the first after every event."""
    after = np.searchsorted(run.time, run["events/time"], side="right")
    evenly = np.linspace(0, len(run.time) - 1, count).astype(int)
    return sorted({*evenly.tolist(), *(after - 1).tolist(), *after.tolist()} & {*range(len(run.time))})


def bodies_of(machine: Machine, run: omnisim.Trajectory, row: int) -> np.ndarray:
    """Bodies where the joint coordinates of a row put them."""
    turnings = [
        Turning(*(run[f"wheels/{wheel}/{name}"][row] for name in ("spin_angle", "spin_rate", "rollers/joint_rate")))
        for wheel in run.wheels
    ]
    position, velocity = run["body/position"][row] * FLAT, run["body/velocity"][row]
    return place(machine, position, velocity, run["body/yaw"][row], run["body/yaw_rate"][row], turnings)


def friction(run: omnisim.Trajectory, row: int, wheel: str, disk: np.ndarray) -> np.ndarray:
    """The force of friction on the roller of a wheel, world axes, N."""
    along, across = run[f"wheels/{wheel}/friction_force"][row]
    return along * cross(disk[AXIS], UP) + across * disk[AXIS]
