"""Fits of the measured mecanum robot, for docs/pages/measured_robots.md (extra study).

    python -m docs.measured_robots picture                          the picture of the page (extra plot)
    python -m docs.measured_robots ideal                            ideal kinematics, with intervals by a bootstrap over runs
    python -m docs.measured_robots FOLDER squares_mended creep      real rollers, kept as FOLDER/squares_mended_creep.json

A fit starts where that of the lengths alone has ended, if that is in the folder. Steps of 50 ms; a fit takes some minutes.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import omnisim
from omnisim.fitting.fit_file import Fit, load_fit, packaged_fits
from omnisim.fitting.fitting import what_is_known
from omnisim.fitting.ideal import IdealPaths
from omnisim.fitting.least_squares import Search
from omnisim.fitting.paths import errors, measured
from omnisim.fitting.simulation import SimulatedPaths, prepared
from omnisim.scene.document import parsed

PICTURE = Path(__file__).parent / "pages/pictures/measured_robot.png"
STEP = 0.05  # s
BRUSH = {"law": "brush", "coefficient": 0.5, "creep_stiffness": 12.0, "slip_speed": 2e-3}
CREEP = {"friction.creep_stiffness": {"start": 12.0, "from": 2.0, "to": 60.0}}
RESISTANCE = {"wheel_types.*.roller.rolling_resistance": {"start": 2e-4, "from": 0.0, "to": 3e-3}}
FREE: dict[str, dict[str, Any]] = {
    "lengths": {},
    "creep": CREEP,
    "resistance": RESISTANCE,
    "both": CREEP | RESISTANCE,
}


def fit_of(logs: str, free: str, folder: Path) -> Fit:
    """The packaged fit of these logs with these keys free beside the lengths, its scene in the folder."""
    path = packaged_fits()[f"omni4_{logs}"]
    data = parsed(path.read_text(encoding="utf-8"), path.name).data
    times = {"time.step": STEP, "time.output_interval": STEP}
    scene = omnisim.load("omni4", times | {f"friction.{key}": value for key, value in BRUSH.items()})
    text = folder / f"omni4_{logs}_{free}.toml"
    text.write_text(scene.text, encoding="utf-8")
    first = folder / f"{logs}_lengths.json"
    known = json.loads(first.read_text(encoding="utf-8"))["estimates"] if first.exists() else {}
    lengths = {key: entry | ({"start": known[key][0]} if known else {}) for key, entry in data["free"].items()}
    entries = [entry | {"file": str(path.parent / entry["file"])} for entry in data["logs"]]
    return load_fit(data | {"scene": str(text), "logs": entries, "free": lengths | FREE[free]})


def found(fit: Fit) -> dict[str, Any]:
    """What the search finds: estimates as [value, low, high], the cost, what the logs cannot tell; of every log its use
    and [end position (m), end yaw (rad), rms position (m)]."""
    prepared(fit)
    paths = SimulatedPaths(fit, 1)
    search = Search(fit, paths, range(len(fit.parameters)), lambda trial: print(trial, flush=True))
    solution = search.solve(fit.start)
    known = what_is_known(fit, solution, search.weights)
    ways = paths(solution.values[None], list(range(len(fit.logs))))[0]
    columns = (solution.values, known.low, known.high)
    return {
        "estimates": {one.key: list(map(float, entry)) for one, *entry in zip(fit.parameters, *columns, strict=True)},
        "correlation": known.correlation.tolist(),
        "cost": float(np.sum(solution.residuals**2)),
        "cannot_tell": known.untold,
        "logs": [
            {"file": log.file, "use": log.use, "errors": errors(way, measured(log, fit.compared(log)))}
            for log, way in zip(fit.logs, ways, strict=True)
        ],
    }


def ideal(logs: str, other: str) -> dict[str, np.ndarray]:
    """What ideal kinematics makes of the logs of one kind, and of the other kind: value and 95 % interval of the mean.

    The intervals are those of a bootstrap over runs, all of it: of the two runs each way round two are drawn, with
    replacement, to fit, and as many of the other kind to test.

    diameter: of a wheel, mm, if all have one. alone: of each run fitted by itself; kind: fitted to one run each way round,
    tested on the two others; other: fitted to four, tested on four of the other kind; mm at the end, deg at the end, mm
    along the way. repeats: half of what two runs one way round end apart, fitted to four of the other kind, mm.
    """
    fit = load_fit(f"omni4_{logs}")
    mine, others = (
        [i for i, log in enumerate(fit.logs) if f"_{kind.partition('_')[0]}_" in log.file] for kind in (logs, other)
    )
    draws = [((0, 0), 1), ((0, 1), 2), ((1, 1), 1)]  # of two runs, and how often of four
    both = [((*one, *(2 + i for i in two)), n * m) for one, n in draws for two, m in draws]
    all_four = values(fit, mine)
    fit = begun(fit, all_four)
    single = begun(one_radius(fit), np.array([all_four[:4].mean(), *all_four[4:]]))
    alone = np.mean([table(fit, [i], [i]) for i in mine], axis=(0, 1))
    kind = np.mean([table(fit, [mine[i], mine[j]], [mine[1 - i], mine[5 - j]]) for i in (0, 1) for j in (2, 3)], axis=1)
    means, diameters, often = [], [], []
    for drawn, n in both:
        fitted = [mine[i] for i in drawn]
        found = table(fit, fitted, others)
        diameters.append(60.0 * values(single, fitted)[0])
        for tested, m in both:
            means.append(found[[*tested]].mean(axis=0))
            often.append(n * m)
    middle = next(n for n, (drawn, _) in enumerate(both) if drawn == (0, 1, 2, 3))
    return {
        "diameter": np.array([diameters[middle], *interval(np.array(diameters), [n for _, n in both])]),
        "alone": alone,
        "kind": np.array([kind.mean(axis=0), kind.min(axis=0), kind.max(axis=0)]),
        "repeats": repeats(fit, all_four, others),
        "other": np.array([means[middle * (len(both) + 1)], *interval(np.array(means), often)]),
    }


def repeats(fit: Fit, estimates: np.ndarray, tested: list[int]) -> np.ndarray:
    """Half of what the errors at the end of two runs one way round are apart, mm, of both ways."""
    paths = IdealPaths(fit)(estimates[None], tested)[0]
    ends = [path.position[-1] - fit.logs[i].position[-1] for i, path in zip(tested, paths, strict=True)]
    return 500.0 * np.array([np.hypot(*(one - other)) for one, other in (ends[:2], ends[2:])])


def interval(found: np.ndarray, often: list[int]) -> np.ndarray:
    """(2, ...): what 95 % of the draws are between."""
    return np.quantile(np.repeat(found, often, axis=0), (0.025, 0.975), axis=0)


def values(fit: Fit, fitted: list[int]) -> np.ndarray:
    """What ideal kinematics estimates from these logs; one may be in it twice."""
    chosen = replace(fit, logs=tuple(replace(fit.logs[i], use="fit") for i in fitted))
    return Search(chosen, IdealPaths(chosen), range(len(fit.parameters)), lambda trial: None).solve(fit.start).values


def table(fit: Fit, fitted: list[int], tested: list[int]) -> np.ndarray:
    """(T, 3): errors of ideal kinematics at the end (mm, deg) and along the way (mm) of each tested log."""
    paths = IdealPaths(fit)(values(fit, fitted)[None], tested)[0]
    found = [
        errors(path, measured(fit.logs[i], fit.compared(fit.logs[i]))) for i, path in zip(tested, paths, strict=True)
    ]
    return np.array([(1e3 * e.end_position, np.degrees(e.end_yaw), 1e3 * e.rms_position) for e in found])


def begun(fit: Fit, start: np.ndarray) -> Fit:
    """The same, its search from there on."""
    return replace(
        fit, parameters=tuple(replace(one, start=value) for one, value in zip(fit.parameters, start, strict=True))
    )


def one_radius(fit: Fit) -> Fit:
    """The same with one factor on the radii of all wheels."""
    radii = [one for one in fit.parameters if one.key.startswith("wheel_types")]
    joined = replace(radii[0], targets=tuple(target for one in radii for target in one.targets))
    return replace(fit, parameters=(joined, *fit.parameters[len(radii) :]))


def draw() -> None:
    """The picture of the page: paths of ideal kinematics fitted to the other kind of path, by both logs."""
    import matplotlib.pyplot as plt

    figure, many = plt.subplots(1, 2, figsize=(9, 4.4), layout="constrained")
    for axes, (kind, other, run) in zip(many, (("squares", "circles", 3), ("circles", "squares", 3)), strict=True):
        for suffix, colour, label in (("", "#d1495b", "log as published"), ("_mended", "#00798c", "each message once")):
            fit = load_fit(f"omni4_{kind}{suffix}")
            i = next(i for i, log in enumerate(fit.logs) if f"{other}_{run}" in log.file)
            path = IdealPaths(fit)(values(fit, fit.fitted)[None], [i])[0][0]
            way = measured(fit.logs[i], fit.compared(fit.logs[i]))
            end = 1e3 * errors(path, way).end_position
            axes.plot(*path.position.T, color=colour, lw=1.3, label=f"{label}: {end:.0f} mm off at the end")
            axes.plot(*path.position[-1], "o", color=colour, ms=5)
        axes.plot(*way.position.T, color="#1f2933", lw=4, alpha=0.2, zorder=0, label="measured")
        axes.plot(*way.position[-1], "o", color="#1f2933", ms=9, alpha=0.3, zorder=0)
        axes.set(aspect="equal", xlabel="x / m", ylabel="y / m", title=f"{other} {run}, by what {kind} tell")
        axes.legend(frameon=False, fontsize=8, loc="center")
    figure.savefig(PICTURE, dpi=110)


def main(folder: str, logs: str = "", free: str = "") -> None:
    """The picture; what ideal kinematics does, printed; or one fit, kept."""
    if folder == "picture":
        return draw()
    if folder == "ideal":
        for name in [logs] if logs else ("squares", "circles", "squares_mended", "circles_mended"):
            told = ideal(name, "circles" if "squares" in name else "squares")
            print(
                name, *(f"{key} {np.round(value, 2).tolist()}" for key, value in told.items()), sep="\n  ", flush=True
            )
        return
    text = json.dumps(found(fit_of(logs, free, Path(folder))), indent=1)
    (Path(folder) / f"{logs}_{free}.json").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
