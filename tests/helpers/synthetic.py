"""Made-up trajectories: right in shape, type and name, without physical meaning."""

import numpy as np

from omnisim.base.status import EVENT_KINDS
from omnisim.results.trajectory import Trajectory

SCENE = 'schema = 1\ntitle = "rollers µ"\n'


def synthetic_attributes(**changes):
    return {
        "omnisim_version": "0.1.0", "title": "rollers µ", "scene": SCENE, "wheels": ("wheel",),
        "model": "bare wheel, 6 rollers, coulomb friction", "tracking": "explicit", "method": "rk4",
        "step": 1e-3, "steps": 10, "rhs_evaluations": 40, "wall_time": 2e-3, "status": "complete",
        "stop_time": 1.0, "stop_wheel": "",
    } | changes  # fmt: skip


def synthetic_data(rows=11, rollers=6, events=3, wheels=("wheel",), seed=0):
    """Random datasets; `rollers` is one number, or one number for each wheel."""
    random = np.random.default_rng(seed).standard_normal
    data = {"time": 0.1 * np.arange(rows)}
    data |= {f"body/{name}": random((rows, 3)) for name in ("position", "velocity", "acceleration")}
    data |= {f"body/{name}": random(rows) for name in ("yaw", "yaw_rate", "yaw_acceleration")}
    for wheel, n in zip(wheels, np.broadcast_to(rollers, len(wheels)), strict=True):
        data |= {f"wheels/{wheel}/{name}": array for name, array in _wheel(random, rows, int(n)).items()}
    for name in ("kinetic", "friction_loss", "bearing_loss", "drive_work", "wrench_work", "balance"):
        data[f"energy/{name}"] = random(rows)
    return data | {f"events/{name}": array for name, array in _events(events, wheels).items()}


def synthetic_trajectory(rows=11, rollers=6, events=3, wheels=("wheel",), **attributes):
    return Trajectory(synthetic_attributes(wheels=wheels, **attributes), synthetic_data(rows, rollers, events, wheels))


def _wheel(random, rows, rollers):
    scalars = ("spin_angle", "spin_rate", "spin_acceleration", "drive_torque", "drive_power", "normal_force",
               "contact_angle", "contact_share", "contact_torque", "servo_torque")  # fmt: skip
    data = {name: random(rows) for name in scalars}
    data["contact_roller"] = np.arange(rows, dtype=np.int64) % rollers
    data["contact_point"] = random((rows, 3))
    data |= {name: random((rows, 2)) for name in ("slip_velocity", "friction_force")}
    data |= {f"rollers/{name}": random((rows, rollers)) for name in ("axial_rate", "joint_rate")}
    centers = ("center_position", "center_velocity", "center_acceleration")
    return data | {f"rollers/{name}": random((rows, rollers, 3)) for name in centers}


def _events(events, wheels):
    count = np.arange(events, dtype=np.int64)
    return {
        "time": 0.25 + 0.5 * count,
        "kind": np.array([EVENT_KINDS[i % len(EVENT_KINDS)] for i in count], dtype=str),
        "wheel": np.array([wheels[i % len(wheels)] if i % 3 < 2 else "" for i in count], dtype=str),
        "roller_from": count - 1,
        "roller_to": -count,
    }
