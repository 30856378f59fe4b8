"""What a trajectory holds, for people."""

from collections import Counter
from html import escape

import numpy as np

from omnisim.base.formatting import aligned, columns
from omnisim.results.layout import ROLLER, ROLLERS, TABLE, WHEELS, Recorded

WHEEL_PEAKS = (
    ("load", "normal_force", "N"),
    ("friction", "friction_force", "N"),
    ("slip", "slip_velocity", "m/s"),
    ("torque", "drive_torque", "N m"),
    ("power", "drive_power", "W"),
)
MOTOR_PEAKS = (
    ("voltage", "voltage", "V"),
    ("current", "current", "A"),
    ("power from the supply", "electrical_power", "W"),
)
ROUNDING = 1e-12  # relative
BEARING_LOADS = ("radial_force", "axial_force", "tilting_moment")


def summary(trajectory: Recorded) -> str:
    """What a trajectory holds, for people: several aligned lines without a final newline."""
    datasets = columns([(f"/{path}", *rest) for path, *rest in dataset_rows(trajectory)])
    parts = [aligned(_facts(trajectory)), extremes(trajectory), bearings(trajectory), datasets]
    return "\n\n".join(filter(None, parts))


def extremes(trajectory: Recorded) -> str:
    """The largest of each wheel's loads, slip, torque and power in the march, the least of what has a sign, the same
    of motors; empty if not recorded."""
    tables = []
    for heading, shown in (("extremes of the march", WHEEL_PEAKS), ("extremes of motors", MOTOR_PEAKS)):
        lines = [(heading, *(f"{name}, {units}" for name, _, units in shown))]
        for wheel in trajectory.wheels if len(trajectory.time) else ():
            if f"interval_max/wheels/{wheel}/{shown[0][1]}" in trajectory:
                lines.append((wheel, *(_range(trajectory, wheel, path) for _, path, _ in shown)))
        tables += [columns(lines)] if len(lines) > 1 else []
    return "\n\n".join(tables)


def _range(trajectory: Recorded, wheel: str, path: str) -> str:
    """The least and the largest value of a wheel's quantity in the march, or the largest of what has no sign; 0 where
    beside another wheel it is rounding."""
    noise = ROUNDING * max(_magnitude(trajectory, f"wheels/{other}/{path}") for other in trajectory.wheels)
    most = largest(trajectory, f"wheels/{wheel}/{path}")
    least = f"interval_min/wheels/{wheel}/{path}"
    values = [trajectory[least].min(), most] if least in trajectory else [most]
    return " to ".join(f"{0.0 if abs(value) < noise else value:.4g}" for value in values)


def largest(trajectory: Recorded, path: str) -> float:
    """The largest value of a quantity in the whole march, by its path below interval_max; NaN without rows."""
    values = trajectory[f"interval_max/{path}"]
    return float(values.max()) if values.size else float("nan")


def peaks(trajectory: Recorded) -> str:
    """The largest magnitudes of loads, slip, torque and power at any wheel in the march; empty if not recorded."""
    found = []
    if not len(trajectory.time):
        return ""
    for name, path, units in WHEEL_PEAKS + MOTOR_PEAKS:
        paths = [f"wheels/{wheel}/{path}" for wheel in trajectory.wheels]
        most = [_magnitude(trajectory, path) for path in paths if f"interval_max/{path}" in trajectory]
        if max(most, default=0.0) > 0.0:
            found.append(f"{name} {max(most):.4g} {units}")
    return ", ".join(found)


def _magnitude(trajectory: Recorded, path: str) -> float:
    """The largest magnitude in the march of a quantity, by its path below interval_max."""
    least = f"interval_min/{path}"
    most = largest(trajectory, path)
    return max(most, float(-trajectory[least].min())) if least in trajectory else most


def bearings(trajectory: Recorded) -> str:
    """Peak in the march and RMS of the rows of what axles and rollers carry, to size bearings by; or nothing.

    Of the rollers, those of the one that carries most.
    """
    lines = []
    for wheel in trajectory.wheels if len(trajectory.time) else ():
        for name, path, along in ((f"{wheel}, axle", WHEELS, 1), (f"{wheel}, rollers", ROLLERS, 2)):
            path = path.format(wheel=wheel)
            if f"interval_max/{path}/bearing_radial_force" in trajectory:
                force, moment = trajectory[f"{path}/bearing_force"], trajectory[f"{path}/bearing_moment"]
                across = [np.linalg.norm(np.delete(load, along, axis=-1), axis=-1) for load in (force, moment)]
                loads = across[0], np.abs(force[..., along]), across[1]
                highest = [_magnitude(trajectory, f"{path}/bearing_{load}") for load in BEARING_LOADS]
                shown = (f"{peak:.4g} ({_rms(load):.4g})" for peak, load in zip(highest, loads, strict=True))
                lines.append((name, *shown))
    header = ("bearing loads: peak (RMS)", "radial, N", "axial, N", "tilting moment, N m")
    return columns([header, *lines]) if lines else ""


def _rms(load: np.ndarray) -> float:
    """Of a load (T) or of several (T, N): the largest."""
    return float(np.sqrt(np.mean(load**2, axis=0)).max())


def odometry(trajectory: Recorded) -> str:
    """How far the odometry of the wheels is off at the end and, in the march, at most; empty if there is none."""
    if "odometry/yaw_error" not in trajectory or not len(trajectory.time):
        return ""
    position, yaw = trajectory["odometry/position_error"][-1], trajectory["odometry/yaw_error"][-1]
    said = f"off by {np.hypot(*position):.3g} m and {abs(yaw):.3g} rad at the end"
    if "interval_max/odometry/position_error" not in trajectory:
        return said
    most, turned = (_magnitude(trajectory, f"odometry/{name}_error") for name in ("position", "yaw"))
    way = distance_travelled(trajectory)
    part = f" ({most / way:.2%} of the {way:.4g} m driven)" if way > 0.0 else ""
    return f"{said}; by {most:.3g} m{part} and {turned:.3g} rad at most"


def distance_travelled(trajectory: Recorded) -> float:
    """Length of the path of the body up to the last row, m: the integral of its speed by the trapezoidal rule."""
    speed = np.linalg.norm(trajectory["body/velocity"], axis=1)
    return float(np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(trajectory.time)))


def accuracy(trajectory: Recorded) -> str:
    """The error estimated and the one that was to be reached; empty if no step was picked for one."""
    a = trajectory.attributes
    if "error_target" not in a:
        return ""
    estimate = f"about {a['error_estimate']:.1e} estimated" if "error_estimate" in a else "no estimate"
    return f"{estimate}, {a['error_target']:g} wanted"


def _facts(trajectory: Recorded) -> dict[str, str]:
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


def _formulation(trajectory: Recorded) -> list[str]:
    """The formulation, if it is not the reduced one."""
    formulation = trajectory.attributes.get("formulation", "reduced")
    return [] if formulation == "reduced" else [f"{formulation} formulation"]


def _constraints(trajectory: Recorded) -> str:
    """How well joints and floor hold the bodies; empty unless they are bodies."""
    if "constraints/position" not in trajectory or not len(trajectory.time):
        return ""
    position, velocity = (trajectory[f"constraints/{name}"].max() for name in ("position", "velocity"))
    drifts = (trajectory[f"constraints/{name}_drift"][-1] for name in ("position", "velocity"))
    drift = " and ".join(f"{value:.2g} {unit}" for value, unit in zip(drifts, ("m", "m/s"), strict=True))
    return f"kept to {position:.2g} m and {velocity:.2g} m/s in every row; put back at every step, by {drift} at most"


SOME = ("bearing_loss", "rolling_loss")  # losses that not every machine has


def _energy(trajectory: Recorded) -> str:
    if not len(trajectory.time):
        return "no rows"
    kinetic = trajectory["energy/kinetic"]
    works = (f"{name.replace('_', ' ')} {trajectory[f'energy/{name}'][-1]:.6g} J"
             for name in ("friction_loss", "bearing_loss", "rolling_loss", "drive_work", "wrench_work")
             if name not in SOME or (f"energy/{name}" in trajectory and trajectory[f"energy/{name}"][-1]))  # fmt: skip
    error = np.abs(trajectory["energy/balance"]).max()
    change = f"kinetic {kinetic[0]:.6g} -> {kinetic[-1]:.6g} J"
    if "energy/gravity" in trajectory:
        gravity = trajectory["energy/gravity"]
        change += f", of gravity {gravity[0]:.6g} -> {gravity[-1]:.6g} J"
    return f"{change}, {', '.join(works)}{_supply(trajectory)}; balanced to {error:.2g} J in every row"


def _supply(trajectory: Recorded) -> str:
    """What motors have taken, and what of it has not become work; empty without motors."""
    if "energy/electrical" not in trajectory:
        return ""
    taken, heat, loss = (trajectory[f"energy/{name}"][-1] for name in ("electrical", "heat", "motor_loss"))
    return f", from the supply {taken:.6g} J (heat in windings {heat:.6g} J, friction of motors {loss:.6g} J)"


def dataset_rows(trajectory: Recorded) -> list[tuple[str, str, str, str]]:
    """One per row of TABLE that is there: path, shape (`6|8` where wheels differ), units, description."""
    wheels = trajectory.wheels
    name = wheels[0] if len(wheels) == 1 else "NAME"
    lines = []
    for row in TABLE:
        paths = (row.path.format(wheel=wheel) for wheel in wheels)
        shapes = [trajectory[path].shape for path in paths if path in trajectory]
        if not shapes:
            continue
        sizes = ["|".join(str(n) for n in dict.fromkeys(axis)) for axis in zip(*shapes, strict=True)]
        lines.append((row.path.format(wheel=name), " x ".join(sizes), row.units, row.description))
    return lines


def in_short(trajectory: Recorded) -> str:
    """What a run shows of itself in Python: a few facts, and how to reach its datasets."""
    facts = _facts(trajectory)
    count = len(trajectory.quantities)
    lines = [f"  {name:9} {facts[name]}" for name in ("duration", "wheels", "events", "method")]
    lines.append(f"  datasets  {count}, as run['wheels/{trajectory.wheels[0]}/slip_velocity']; list(run) names all")
    return "\n".join([f"{facts['title']!r}: {facts['status']}", *lines])


def as_html(trajectory: Recorded) -> str:
    """What a notebook shows of a trajectory: a few facts, and the datasets behind a click; needs nothing else."""
    facts = _facts(trajectory)
    told = "".join(
        f"<tr><th style='text-align:left'>{name}</th><td style='text-align:left'>{escape(facts[name])}</td></tr>"
        for name in ("title", "status", "duration", "wheels", "events", "model", "method")
    )
    rows = dataset_rows(trajectory)
    cells = "".join(
        "<tr>" + "".join(f"<td style='text-align:left'>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    head = "<tr><th>dataset</th><th>shape</th><th>units</th><th></th></tr>"
    summary = f"<summary>{len(rows)} datasets</summary>"
    return f"<div><table>{told}</table><details>{summary}<table>{head}{cells}</table></details></div>"
