"""What a trajectory holds, for people."""

from collections import Counter

import numpy as np

from omnisim.text import aligned, columns
from omnisim.trajectory import ROLLER, ROLLERS, TABLE, WHEEL, Trajectory


def summary(trajectory: Trajectory) -> str:
    """What a trajectory holds, for people: several aligned lines without a final newline."""
    return "\n\n".join(filter(None, [aligned(_facts(trajectory)), bearings(trajectory), _datasets(trajectory)]))


def bearings(trajectory: Trajectory) -> str:
    """Peak and RMS of what each wheel's axle and its rollers carry, for the sizing of bearings; empty if not recorded.

    Of the rollers, those of the one that carries most.
    """
    lines = []
    for wheel in trajectory.wheels if len(trajectory.time) else ():
        for name, path, along in ((f"{wheel}, axle", WHEEL, 1), (f"{wheel}, rollers", ROLLERS, 2)):
            path = path.format(wheel=wheel)
            if f"{path}/bearing_force" in trajectory:
                force, moment = trajectory[f"{path}/bearing_force"], trajectory[f"{path}/bearing_moment"]
                across = [np.linalg.norm(np.delete(load, along, axis=-1), axis=-1) for load in (force, moment)]
                loads = across[0], np.abs(force[..., along]), across[1]
                lines.append((name, *(f"{_peak(load):.4g} ({_rms(load):.4g})" for load in loads)))
    header = ("bearing loads: peak (RMS)", "radial, N", "axial, N", "tilting moment, N m")
    return columns([header, *lines]) if lines else ""


def _peak(load: np.ndarray) -> float:
    return float(load.max())


def _rms(load: np.ndarray) -> float:
    """Of a load (T) or of several (T, N): the largest."""
    return float(np.sqrt(np.mean(load**2, axis=0)).max())


def odometry(trajectory: Trajectory) -> str:
    """How far the odometry of the wheels is off in the last row; empty if there is none."""
    if "odometry/yaw_error" not in trajectory or not len(trajectory.time):
        return ""
    position, yaw = trajectory["odometry/position_error"][-1], trajectory["odometry/yaw_error"][-1]
    return f"off by {np.hypot(*position):.3g} m and {abs(yaw):.3g} rad at the end"


def accuracy(trajectory: Trajectory) -> str:
    """The error estimated and the one that was to be reached; empty if no step was picked for one."""
    a = trajectory.attributes
    if "error_target" not in a:
        return ""
    estimate = f"about {a['error_estimate']:.1e} estimated" if "error_estimate" in a else "no estimate"
    return f"{estimate}, {a['error_target']:g} wanted"


def _facts(trajectory: Trajectory) -> dict[str, str]:
    a, time = trajectory.attributes, trajectory.time
    end = time[-1] if len(time) else 0.0
    interval = f", one every {end / (len(time) - 1):g} s" if len(time) > 1 else ""
    speed = f", {end / a['wall_time']:.3g} times real time" if end > 0 and a["wall_time"] > 0 else ""
    rollers = {wheel: len(trajectory[ROLLER.format(wheel=wheel)]) for wheel in trajectory.wheels}
    kinds = Counter(trajectory["events/kind"].tolist())
    return {
        "title": a["title"] or "(none)",
        "model": a["model"],
        "method": ", ".join(
            [a["method"], f"step {a['step']:g} s", f"{a['tracking']} tracking", *_formulation(trajectory)]
        ),
        "error": accuracy(trajectory),
        "run": f"{a['steps']} steps, {a['rhs_evaluations']} right-hand sides, {a['wall_time']:.3g} s{speed}",
        "duration": f"{end:g} s, {len(time)} rows{interval}",
        "status": a["status"],
        "wheels": ", ".join(f"{wheel} ({n} rollers)" for wheel, n in rollers.items()),
        "events": ", ".join(f"{n} {kind}" for kind, n in kinds.most_common()) or "none",
        "energy": _energy(trajectory),
        "odometry": odometry(trajectory),
        "constraints": _constraints(trajectory),
        "format": f"{a['format']} {a['format_version']}, written by omnisim {a['omnisim_version']}",
    }


def _formulation(trajectory: Trajectory) -> list[str]:
    """The formulation, if it is not the reduced one."""
    formulation = trajectory.attributes.get("formulation", "reduced")
    return [] if formulation == "reduced" else [f"{formulation} formulation"]


def _constraints(trajectory: Trajectory) -> str:
    """How well joints and floor hold the bodies; empty unless they are bodies."""
    if "constraints/position" not in trajectory or not len(trajectory.time):
        return ""
    position, velocity = (trajectory[f"constraints/{name}"].max() for name in ("position", "velocity"))
    drifts = (trajectory[f"constraints/{name}_drift"][-1] for name in ("position", "velocity"))
    drift = " and ".join(f"{value:.2g} {unit}" for value, unit in zip(drifts, ("m", "m/s"), strict=True))
    return f"kept to {position:.2g} m and {velocity:.2g} m/s; put back at every step, by {drift} at most"


def _energy(trajectory: Trajectory) -> str:
    if not len(trajectory.time):
        return "no rows"
    kinetic = trajectory["energy/kinetic"]
    works = (f"{name.replace('_', ' ')} {trajectory[f'energy/{name}'][-1]:.6g} J"
             for name in ("friction_loss", "bearing_loss", "drive_work", "wrench_work")
             if name != "bearing_loss" or trajectory["energy/bearing_loss"][-1])  # fmt: skip
    error = np.abs(trajectory["energy/balance"]).max()
    change = f"kinetic {kinetic[0]:.6g} -> {kinetic[-1]:.6g} J"
    if "energy/gravity" in trajectory:
        gravity = trajectory["energy/gravity"]
        change += f", of gravity {gravity[0]:.6g} -> {gravity[-1]:.6g} J"
    return f"{change}, {', '.join(works)}; balanced to {error:.2g} J"


def _datasets(trajectory: Trajectory) -> str:
    """One line per row of TABLE: path, shape (`6|8` where wheels differ), units, description."""
    wheels = trajectory.wheels
    name = wheels[0] if len(wheels) == 1 else "NAME"
    lines = []
    for row in TABLE:
        if row.path.format(wheel=wheels[0]) not in trajectory:
            continue
        shapes = [trajectory[row.path.format(wheel=wheel)].shape for wheel in wheels]
        sizes = ["|".join(str(n) for n in dict.fromkeys(axis)) for axis in zip(*shapes, strict=True)]
        lines.append(("/" + row.path.format(wheel=name), " x ".join(sizes), row.units, row.description))
    return columns(lines)
