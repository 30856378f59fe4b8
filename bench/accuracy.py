"""Errors and observed orders, from easy scenes to hard ones: what is the same on every machine, however fast it is.

The scenes and their references are those of precision.py, which times them.
"""

import math

from bench import alike
from bench.common import Claim, table
from bench.precision_scenes import ENTRIES, Entry, chosen
from omnisim.run import work_precision
from omnisim.run.work_precision import Precision, finest_orders
from omnisim_cli.bench_report import error_text, row_data

BY_POWER = 1.0, 1.5  # errors of longer steps by a power of the step: target and alarm
TARGETS = {"heun": 1.9, "rk4": 3.8, "dopri5": 4.7, "bs5": 4.7}  # orders


def measure(rounds: int) -> dict:
    """By scene, in one round or, of few scenes, none: errors, work and orders by method, and the scene's own step."""
    entries, methods = chosen(rounds < 1)
    return {name: measure_entry(entry, methods) for name, entry in entries.items()}


def measure_entry(entry: Entry, methods: tuple[str, ...]) -> dict:
    scene = entry.scene()
    found = work_precision.exact(scene, entry.settings(methods))
    orders = {method: order for (method, tracking), order in finest_orders(found).items() if tracking == "explicit"}
    over_many = {}
    if entry.alike is not None:
        over_many = alike.orders(scene, entry.alike, [method for method in methods if method in TARGETS], entry.steps)
    return {
        "title": scene.config.title,
        "law": scene.config.friction.law,
        "own_step_s": scene.config.time.step,
        "orders": orders | {method: found.order for method, found in over_many.items()},
        "alike": {method: order._asdict() for method, order in over_many.items()},
        "rows": [row_data(row) for row in found.rows],
        "report": "\n\n".join([listed(found), *([alike.told(over_many)] if over_many else [])]),
    }


def listed(found: Precision) -> str:
    """Every setting of one scene."""
    header = ["method", "tracking", "step, s", "error, m or rad", "observed order", "right-hand sides", "events"]
    trusted = found.reference.distance
    rows = [
        [row.method, row.tracking, f"{row.step:g}", "stopped" if row.error is None else error_text(row, trusted),
         "-" if row.order is None else f"{row.order:.2f}", row.evaluations, row.events]
        for row in found.rows
    ]  # fmt: skip
    return table(header, rows)


def report(result: dict) -> str:
    rows = []
    for name, data in result.items():
        errors = {method: f" ± {found['uncertainty']:.2f}" for method, found in data["alike"].items()}
        told = ((method, order) for method, order in data["orders"].items() if method in TARGETS)
        orders = ", ".join(f"{method} {order:.2f}{errors.get(method, '')}" for method, order in told)
        rows.append([name, data["law"], orders or "-"])
    scenes = (f"### {data['title']}\n\n{data['report']}" for data in result.values())
    return "\n\n".join([table(["scene", "friction", "observed orders"], rows), *scenes])


def claims(result: dict) -> list[Claim]:
    """Orders where the errors tell them, errors by a power of the step, and errors at the scene's own step."""
    found = []
    for name, data in result.items():
        for method, order in data["orders"].items():
            if method in TARGETS:
                limits = TARGETS[method], ENTRIES[name].alarms[method]
                reason = below_its_power(data["alike"][method]) if method in data["alike"] else ""
                found.append(Claim(f"observed order of {method}, {name}", order, "at least", *limits, reason))
        for method, over_many in data["alike"].items():
            text = f"errors of {method} over machines like {name}, at most, by h^p through that of the shortest step"
            found.append(Claim(text, over_many["by_power"], "at most", *BY_POWER, below_its_power(over_many)))
        for method, bound in ENTRIES[name].bounds.items():
            (error,) = (row["error"] for row in data["rows"] if own_step(row, method, data["own_step_s"]))
            text = f"error by {method} at {data['own_step_s']:g} s, {name}"
            found.append(Claim(text, math.nan if error is None else error, "at most", bound, bound))
    return found


def below_its_power(found: dict) -> str:
    """Why an order over many machines (alike.Order) may be less than that of its method."""
    return (
        f"The mean of {alike.MACHINES} machines has a standard error of {found['uncertainty']:.2f}; longer steps err "
        f"at most {found['by_power']:.2f} ± {found['by_power_uncertainty']:.2f} of that power of the step which goes "
        f"through the error at {list(found['errors'])[-1]} s"
    )


def own_step(row: dict, method: str, step: float) -> bool:
    return (row["method"], row["tracking"], row["step_s"]) == (method, "explicit", step)
