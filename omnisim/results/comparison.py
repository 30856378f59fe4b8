"""What trajectories say: how well energy balances, and how far two of them lie apart."""

from dataclasses import dataclass

import numpy as np

from omnisim.results.layout import EVENT_NUMBER, TIME, Quantity
from omnisim.results.trajectory import Trajectory

STANDING = 1e-8  # m/s or rad/s: what moves more slowly than that stands
BARELY = 1e-6  # of the energy turned over: less than that at the start measures nothing
# Largest differences of two contact trackings that the paper reports for the height of a roller's centre, SI units
PAPER = {"acceleration": 1e-8, "velocity": 1e-7, "position": 1e-6}


@dataclass(frozen=True)
class EnergyError:
    """Largest |balance| (J), and the energy that it is measured by.

    That is the initial kinetic energy, or else, and of what barely moves at the start, what friction, drives, wrench
    and gravity turn over (0: nothing moves).
    """

    absolute: float
    scale: float
    scale_name: str

    @property
    def relative(self) -> float:
        return self.absolute / self.scale if self.scale else 0.0


def energy_error(trajectory: Trajectory) -> EnergyError:
    """The numerical error of a run, as its energies tell it."""
    kinetic = trajectory["energy/kinetic"]
    error = float(np.abs(trajectory["energy/balance"]).max(initial=0.0))
    turned = [trajectory["energy/friction_loss"], *works(trajectory)]
    turned_over = float(sum(np.abs(work).max(initial=0.0) for work in turned))
    if len(kinetic) and kinetic[0] > BARELY * turned_over:
        return EnergyError(error, float(kinetic[0]), "the initial kinetic energy")
    return EnergyError(error, 0.0 if stands(trajectory) else turned_over, "the energy turned over")


def works(trajectory: Trajectory) -> list[np.ndarray]:
    """Works on the machine since t = 0, J: of the drives, of the wrench, and of the weight on a slope."""
    found = [trajectory["energy/drive_work"], trajectory["energy/wrench_work"]]
    if "energy/gravity" in trajectory:
        found.append(trajectory["energy/gravity"][:1] - trajectory["energy/gravity"])
    return found


def stands(trajectory: Trajectory) -> bool:
    """Whether no body and no wheel ever moves, but for rounding."""
    spins = (f"wheels/{wheel}/spin_rate" for wheel in trajectory.wheels)
    return not any(np.any(np.abs(trajectory[path]) > STANDING) for path in ("body/velocity", "body/yaw_rate", *spins))


def unaccounted(trajectory: Trajectory) -> float:
    """Part of all energy that was there at the start or came in since, for which no row accounts.

    Nothing of what stands: there is only rounding. A run of which it exceeds 5 % stops (validity.py).
    """
    if stands(trajectory):
        return 0.0
    turnover = float(np.max(trajectory["energy/kinetic"][0] + sum(map(np.abs, works(trajectory)))))
    return energy_error(trajectory).absolute / turnover if turnover > 0.0 else 0.0


@dataclass(frozen=True)
class Difference:
    """How far a dataset of two trajectories differs at most.

    `largest` is the largest magnitude in the first, in `units`. Of rollers and words, `difference` of
    `largest` entries are not the same.
    """

    path: str
    units: str
    largest: float
    difference: float


@dataclass(frozen=True)
class Comparison:
    """Two trajectories of one scene with equal output intervals.

    rows      how many both have
    apart     how many of them have different rollers in contact: they lie between the exchange times of the
              two, where accelerations and contact points jump, and are left out of the differences
    events    how many each has; differences are taken over the first ones, as many as both have
    """

    rows: int
    apart: int
    events: tuple[int, int]
    differences: tuple[Difference, ...]
    centre_height: tuple[Difference, ...]  # of the first wheel's roller 0: acceleration, velocity, position


def compare(a: Trajectory, b: Trajectory) -> Comparison:
    """Largest differences over all rows that both trajectories have."""
    same = same_contacts(a, b)
    rows = len(same)
    events = len(a["events/time"]), len(b["events/time"])
    chosen = {TIME: np.flatnonzero(same), EVENT_NUMBER: np.arange(min(events))}
    table = [row for row in a.quantities if not row.is_scale and row.path in b]
    differences = tuple(difference(row, a[row.path], b[row.path], chosen) for row in table)
    return Comparison(rows, rows - int(same.sum()), events, differences, centre_height(a, b, chosen[TIME]))


def same_contacts(a: Trajectory, b: Trajectory) -> np.ndarray:
    """In which of the rows that both have the same rollers touch the floor (rows), bool."""
    rows = min(len(a.time), len(b.time))
    same = np.ones(rows, bool)
    for wheel in a.wheels:
        path = f"wheels/{wheel}/contact_roller"
        same &= a[path][:rows] == b[path][:rows]
    return same


@dataclass(frozen=True)
class Divergence:
    """Largest differences of two trajectories in all rows until a time (s): of the body's position (m) and velocity
    (m/s), of yaw and spin angles (rad), and of normal forces (N)."""

    until: float
    position: float
    angle: float
    velocity: float
    normal_force: float


def divergence(a: Trajectory, b: Trajectory, pieces: int = 5) -> list[Divergence]:
    """How two trajectories of one scene part: until each of so many equal parts of the time that both have."""
    rows = min(len(a.time), len(b.time))
    found = []
    angles = ["body/yaw", *(f"wheels/{wheel}/spin_angle" for wheel in a.wheels)]
    groups = (["body/position"], angles, ["body/velocity"], [f"wheels/{wheel}/normal_force" for wheel in a.wheels])
    for end in dict.fromkeys(np.linspace(0, rows, pieces + 1).round().astype(int)[1:].tolist()):
        if not end:
            continue
        sizes = [max(float(np.abs(a[path][:end] - b[path][:end]).max()) for path in group) for group in groups]
        found.append(Divergence(float(a.time[end - 1]), *sizes))
    return found


def distance(a: Trajectory, b: Trajectory) -> float:
    """Largest over the rows that both have of that of positions (m), yaws and spin angles (rad)."""
    rows = min(len(a.time), len(b.time))
    if not rows:
        return 0.0
    paths = ["body/position", "body/yaw", *(f"wheels/{wheel}/spin_angle" for wheel in a.wheels)]
    apart = [(a[path][:rows] - b[path][:rows]).reshape(rows, -1) for path in paths]
    return max(float(np.linalg.norm(gaps, axis=1).max(initial=0.0)) for gaps in apart)


def difference(quantity: Quantity, a: np.ndarray, b: np.ndarray, chosen: dict[str, np.ndarray]) -> Difference:
    """Over the chosen rows or events of one dataset."""
    first = quantity.axes[0]
    a, b = a[chosen[first]], b[chosen[first]]
    if quantity.dtype != "float64":
        return Difference(quantity.path, "entries", float(a.size), float(np.sum(a != b)))
    return largest_difference(quantity.path, quantity.units, a, b)


def largest_difference(path: str, units: str, a: np.ndarray, b: np.ndarray) -> Difference:
    """Over all entries of two arrays."""
    largest, apart = (float(np.abs(values).max(initial=0.0)) for values in (a, a - b))
    return Difference(path, units, largest, apart)


def centre_height(a: Trajectory, b: Trajectory, rows: np.ndarray) -> tuple[Difference, ...]:
    """Of the height of the centre of the first wheel's roller 0: what the paper compares."""
    found = []
    for name, units in (("acceleration", "m/s^2"), ("velocity", "m/s"), ("position", "m")):
        path = f"wheels/{a.wheels[0]}/rollers/center_{name}"
        found.append(largest_difference(name, units, a[path][rows, 0, 2], b[path][rows, 0, 2]))
    return tuple(found)
