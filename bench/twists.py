"""The youBot and the kiwi follow twists: true pose against odometry, ripple, torques, slip.

Odometry takes the wheels as ideal, cos(q) = 1. A real roller that rolls without slip along its axis obeys

    phi' R = V_h - l yaw_rate - V_k tan(psi) / cos(q)

q: angle of the roller in contact from straight down, from -alpha to alpha, rad; l: contact point from the middle of the
wheel along the axle, m. For psi = 0, l = 0 and phi' R = V_h: odometry is right. For psi = 45 deg, at a constant rate,

    sideways            V = phi' R cos(q)                  mean: sin(alpha) / alpha              of the odometry
    diagonal, 45 deg    V = phi' R / (1 + 1 / cos(q))      mean: 2 - 2 tan(alpha / 2) / alpha    of the odometry

In the rotation the wheels' l differ, the four conditions contradict each other, and wheels slip all the time.
"""

from typing import NamedTuple

import numpy as np

import omnisim
from bench.common import Claim, table
from omnisim.results.trajectory import Trajectory

RAMP, HOLD = 0.5, 2.0  # s: the command rises linearly; from HOLD on the motion is steady
STEP, INTERVAL = 5e-4, 2e-3  # s
TWISTS = {
    "youbot": {"forward": (0.5, 0, 0), "sideways": (0, 0.5, 0), "rotation": (0, 0, 1.0), "diagonal": (0.35, 0.35, 0)},
    "kiwi": {"forward": (0.15, 0, 0), "sideways": (0, 0.15, 0), "rotation": (0, 0, 1.0), "diagonal": (0.1, 0.1, 0)},
}  # m/s, m/s, rad/s
NOTES = """Pose at the end; odometry error in per cent of the distance or angle that it reports, below 0 where the
machine got less far. Ripple: peak to peak from 2 s on, of the speed along the command (in a rotation of the yaw rate),
and in per cent of it. Torque: root mean square of all wheels from 2 s on, and the peak of the whole run. Slip: the
largest of any wheel."""


class Pose(NamedTuple):
    """Position (m) and yaw (rad)."""

    position: np.ndarray
    yaw: float


def follow(machine: str, twist: tuple[float, float, float], end: float, *overrides: str) -> Trajectory:
    """From rest, a ramp of the command and then its constant value."""
    command = f"command={{times=[0.0, {RAMP}], twist=[[0.0, 0.0, 0.0], {[float(value) for value in twist]}]}}"
    time = (f"time.end={end!r}", f"time.step={STEP!r}", f"time.output_interval={INTERVAL!r}")
    found = omnisim.simulate(omnisim.load(machine, (*time, "solver.method=rk4", command, *overrides)))
    if not found.complete:
        raise RuntimeError(found.attributes["status"])
    return found


def rolled(found: Trajectory, wheel: str, radius: float, alpha: float) -> np.ndarray:
    """Distance in every row of a sideways motion at psi = 45 deg without slip, m: the integral of R cos(q) dphi."""
    spin = found[f"wheels/{wheel}/spin_angle"]
    pitches = np.round(spin / (2.0 * alpha))
    return radius * (2.0 * pitches * np.sin(alpha) + np.sin(spin - 2.0 * pitches * alpha))


def measure(seconds: int) -> list[dict[str, object]]:
    """seconds: of each motion."""
    return [row(machine, name, float(seconds)) for machine, twists in TWISTS.items() for name in twists]


def row(machine: str, name: str, seconds: float) -> dict[str, object]:
    twist = np.array(TWISTS[machine][name])
    found = follow(machine, tuple(twist), seconds)
    end, steady = len(found.time) - 1, found.time >= min(HOLD, seconds / 2)
    pose = Pose(found["body/position"][end, :2], float(found["body/yaw"][end]))
    odometry = Pose(found["odometry/position"][end], float(found["odometry/yaw"][end]))
    turns = not twist[:2].any()
    speed = found["body/yaw_rate"] if turns else forward(found) @ (twist[:2] / np.hypot(*twist[:2]))
    torque, slip = (of_wheels(found, path) for path in ("drive_torque", "slip_velocity"))
    slip = np.hypot(slip[..., 0], slip[..., 1]).max(axis=1)
    lost = pose.yaw - odometry.yaw if turns else np.hypot(*pose.position) - np.hypot(*odometry.position)
    reported = odometry.yaw if turns else np.hypot(*odometry.position)
    return {
        "machine": machine,
        "twist": name,
        "command": [float(value) for value in twist],
        "x": float(pose.position[0]),
        "y": float(pose.position[1]),
        "yaw": pose.yaw,
        "position_error": float(np.hypot(*(pose.position - odometry.position))),
        "yaw_error": pose.yaw - odometry.yaw,
        "lost": float(lost / reported),
        "ripple": float(np.ptp(speed[steady])),
        "relative_ripple": float(np.ptp(speed[steady]) / np.mean(speed[steady])),
        "unit": "mrad/s" if turns else "mm/s",
        "torque": float(np.sqrt(np.mean(torque[steady] ** 2))),
        "peak_torque": float(np.abs(torque).max()),
        "exchanges": float(np.sum(found["events/kind"] == "exchange") / seconds),
        "slip": float(slip.max()),
        "steady_slip": float(slip[steady].max()),
    }


def forward(found: Trajectory) -> np.ndarray:
    """Velocity in chassis axes, m/s (T, 2)."""
    velocity, turn = found["body/velocity"][:, :2] @ [1.0, 1j], np.exp(-1j * found["body/yaw"])
    return np.column_stack([(velocity * turn).real, (velocity * turn).imag])


def of_wheels(found: Trajectory, path: str) -> np.ndarray:
    """A dataset of every wheel, stacked on the second axis."""
    return np.stack([found[f"wheels/{wheel}/{path}"] for wheel in found.wheels], axis=1)


def report(rows: list[dict[str, object]]) -> str:
    poses = [
        [line["machine"], line["twist"], *(f"{value:g}" for value in line["command"]), f"{line['x']:z.4f}",
         f"{line['y']:z.4f}", f"{line['yaw']:z.4f}", f"{1e3 * line['position_error']:.3g}",
         f"{1e3 * line['yaw_error']:.3g}", f"{100 * line['lost']:.2g}"] for line in rows
    ]  # fmt: skip
    header = ["machine", "twist", "vx, m/s", "vy, m/s", "yaw rate, rad/s", "x, m", "y, m", "yaw, rad",
              "odometry error, mm", "of yaw, mrad", "per cent"]  # fmt: skip
    loads = [
        [line["machine"], line["twist"], f"{1e3 * line['ripple']:.2g} {line['unit']}",
         f"{100 * line['relative_ripple']:.2g}", f"{line['torque']:.2g}", f"{line['peak_torque']:.2g}",
         f"{line['exchanges']:.0f}", f"{1e3 * line['slip']:.3g}", f"{1e3 * line['steady_slip']:.3g}"] for line in rows
    ]  # fmt: skip
    names = ["machine", "twist", "ripple", "per cent", "rms torque, N m", "peak, N m", "exchanges per second",
             "slip, mm/s", "from 2 s on"]  # fmt: skip
    return "\n\n".join([table(header, poses), table(names, loads), NOTES])


def claims(_rows: list[dict[str, object]]) -> list[Claim]:
    return []  # tests/laws/test_twists.py holds the motions to their closed forms
