"""Forces and slip at the contacts of a run, as arrows that other tools draw: where from, which way, how long."""

import math
from typing import NamedTuple

import numpy as np

from omnisim.dynamics.ground import floor_of_scene
from omnisim.exports.frames import Frames, Y, Z, turned
from omnisim.pictures.ground import normals

LONGEST = 1.7  # wheel radii, at most, as on the page of `omnisim view`
SHORTEST = 0.01  # wheel radii: what is shorter nobody sees
STILL = 0.01  # m/s: slip below is no slip worth the longest arrow
FLAT = 1e-9  # sine between axle and normal, of a wheel that lies on its side: it heads nowhere
STEPS = (1.0, 2.0, 5.0)  # lengths are so many times a power of ten


class Arrows(NamedTuple):
    """Of one kind at one wheel: points (T, 3) that they start from and their tips (T, 3), m, and whether they are there
    (T,)."""

    kind: str
    wheel: int
    tail: np.ndarray
    tip: np.ndarray
    shown: np.ndarray


class Scales(NamedTuple):
    """Lengths of arrows: m by N, and m by m/s."""

    force: float
    slip: float


def scales(frames: Frames) -> Scales:
    """Round ones, with which the largest load and slip of the run are as long as arrows may be."""
    run, longest = frames.trajectory, LONGEST * radius(frames)
    loads = [run[f"wheels/{wheel}/normal_force"].max(initial=0.0) for wheel in run.wheels]
    slips = [np.hypot(*run[f"wheels/{wheel}/slip_velocity"].T).max(initial=STILL) for wheel in run.wheels]
    return Scales(rounded(longest / (max(loads) or 1.0)), rounded(longest / max(slips)))


def rounded(value: float) -> float:
    """The largest of 1, 2 and 5 times powers of ten that is no larger."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step for step in STEPS if step * power <= value or step == STEPS[0]) * power


def radius(frames: Frames) -> float:
    """Of the largest wheel, m."""
    return max(frames.config.type_of(wheel).radius for wheel in frames.config.wheels)


def arrows(frames: Frames, lengths: Scales) -> list[Arrows]:
    """Load, friction and slip at every wheel; none where it is in the air."""
    run, shortest, found = frames.trajectory, SHORTEST * radius(frames), []
    for number, name in enumerate(run.wheels):
        path = f"wheels/{name}"
        ahead, left, up = contact_axes(frames, name)
        point, load = run[f"{path}/contact_point"], run[f"{path}/normal_force"]
        vectors = {
            "normal": lengths.force * load[:, None] * up,
            "friction": lengths.force * along(run[f"{path}/friction_force"], ahead, left),
            "slip": lengths.slip * along(run[f"{path}/slip_velocity"], ahead, left),
        }
        for kind, vector in vectors.items():
            shown = (load > 0.0) & (np.linalg.norm(vector, axis=1) > shortest)
            found.append(Arrows(kind, number, point, point + vector, shown))
    return found


def contact_axes(frames: Frames, wheel: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """h, k and n (T, 3) of a wheel's contact in the world: where it heads along the ground, across, normal to it."""
    floor = floor_of_scene(frames.config)
    x, y, _ = frames.trajectory[f"wheels/{wheel}/contact_point"].T
    up = np.broadcast_to(Z, (len(x), 3)) if floor is None else normals(floor, x, y)
    ahead = np.cross(turned(frames.in_world(f"{wheel}_wheel").orientation, Y), up)
    ahead = ahead / np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), FLAT)
    return ahead, np.cross(up, ahead), up


def along(components: np.ndarray, ahead: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Components (T, 2) along h and k, in the world (T, 3)."""
    return components[:, :1] * ahead + components[:, 1:] * left
