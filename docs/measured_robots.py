"""The measured mecanum robot by ideal kinematics, for docs/pages/measured_robots.md (extra study).

python -m docs.measured_robots picture      the picture of the page (extra plot)
python -m docs.measured_robots ideal        what ideal kinematics does, with intervals by a bootstrap over runs
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from omnisim.fitting.fit_file import Fit, load_fit
from omnisim.fitting.ideal import IdealPaths
from omnisim.fitting.least_squares import Paths, Search
from omnisim.fitting.paths import errors, measured

Ways = Callable[[Fit], Paths]
PICTURE = Path(__file__).parent / "pages/pictures/measured_robot.png"
DRAWS = tuple(  # of four runs, two each way round: which are drawn with replacement, and how often of 16 times
    ((*one, *(2 + i for i in two)), n * m)
    for one, n in (((0, 0), 1), ((0, 1), 2), ((1, 1), 1))
    for two, m in (((0, 0), 1), ((0, 1), 2), ((1, 1), 1))
)
ALL = next(i for i, (drawn, _) in enumerate(DRAWS) if drawn == (0, 1, 2, 3))


class Transfer(NamedTuple):
    """What a fit tells of runs that it has not seen: (mm at the end, deg at the end, mm along the way), means.

    kind (4, 3): fitted to one run each way round, tested on the two others. other (81, 3): fitted to one of DRAWS, tested
    on one of DRAWS of the other kind of path. estimates (9, P): those of the first.
    """

    kind: np.ndarray
    other: np.ndarray
    estimates: np.ndarray

    @property
    def middle(self) -> np.ndarray:
        """(3,) of all four runs, tested on all four of the other kind."""
        return self.other[ALL * (len(DRAWS) + 1)]


OFTEN = np.array([n * m for _, n in DRAWS for _, m in DRAWS])  # the rows of `other` are drawn


def ideal(logs: str, other: str) -> dict[str, np.ndarray]:
    """What ideal kinematics makes of the logs of one kind, and of the other kind: value and 95 % interval of the mean.

    diameter: of a wheel, mm, if all have one. alone: of each run fitted by itself; kind, other: see `Transfer`; mm at the
    end, deg at the end, mm along the way. repeats: half of what two runs one way round end apart, fitted to four of the
    other kind, mm.
    """
    fit = load_fit(f"omni4_{logs}")
    mine, others = (of_kind(fit, kind.partition("_")[0]) for kind in (logs, other))
    all_four = values(fit, mine)
    fit = begun(fit, all_four)
    single = begun(one_radius(fit), np.array([all_four[:4].mean(), *all_four[4:]]))
    diameters = np.array([60.0 * values(single, [mine[i] for i in drawn])[0] for drawn, _ in DRAWS])
    found = transfer(fit, mine, others)
    return {
        "diameter": np.array([diameters[ALL], *interval(diameters, [n for _, n in DRAWS])]),
        "alone": np.mean([table(fit, [i], [i]) for i in mine], axis=(0, 1)),
        "kind": np.array([found.kind.mean(axis=0), found.kind.min(axis=0), found.kind.max(axis=0)]),
        "repeats": repeats(fit, all_four, others),
        "other": np.array([found.middle, *interval(found.other, OFTEN)]),
    }


def of_kind(fit: Fit, kind: str) -> list[int]:
    """Numbers of the four logs of one kind of path: two one way round, two the other."""
    return [i for i, log in enumerate(fit.logs) if f"_{kind}_" in log.file]


def transfer(fit: Fit, mine: list[int], others: list[int], ways: Ways = IdealPaths) -> Transfer:
    """Fitted to runs of one kind, tested on the rest of them and on the other kind. Intervals of a bootstrap over runs,
    all of it: of the two runs each way round two are drawn to fit, and as many of the other kind to test."""
    pairs = [(i, j) for i in (0, 1) for j in (2, 3)]
    kind = [table(fit, [mine[i], mine[j]], [mine[1 - i], mine[5 - j]], ways).mean(axis=0) for i, j in pairs]
    estimates = [values(fit, [mine[i] for i in drawn], ways) for drawn, _ in DRAWS]
    other = []
    for found in estimates:
        rows = errors_on(fit, found, others, ways)
        other += [rows[[*drawn]].mean(axis=0) for drawn, _ in DRAWS]
    return Transfer(np.array(kind), np.array(other), np.array(estimates))


def repeats(fit: Fit, estimates: np.ndarray, tested: list[int]) -> np.ndarray:
    """Half of what the errors at the end of two runs one way round are apart, mm, of both ways."""
    paths = IdealPaths(fit)(estimates[None], tested)[0]
    ends = [path.position[-1] - fit.logs[i].position[-1] for i, path in zip(tested, paths, strict=True)]
    return 500.0 * np.array([np.hypot(*(one - other)) for one, other in (ends[:2], ends[2:])])


def interval(found: np.ndarray, often: Sequence[int] | np.ndarray) -> np.ndarray:
    """(2, ...): what 95 % of the draws are between."""
    return np.quantile(np.repeat(found, often, axis=0), (0.025, 0.975), axis=0)


def values(fit: Fit, fitted: list[int], ways: Ways = IdealPaths) -> np.ndarray:
    """What these ways to paths estimate from these logs; one may be in it twice."""
    chosen = replace(fit, logs=tuple(replace(fit.logs[i], use="fit") for i in fitted))
    return Search(chosen, ways(chosen), range(len(fit.parameters)), lambda trial: None).solve(fit.start).values


def table(fit: Fit, fitted: list[int], others: list[int], ways: Ways = IdealPaths) -> np.ndarray:
    """(T, 3): errors at the end (mm, deg) and along the way (mm) of each other log."""
    return errors_on(fit, values(fit, fitted, ways), others, ways)


def errors_on(fit: Fit, estimates: np.ndarray, logs: list[int], ways: Ways = IdealPaths) -> np.ndarray:
    """(T, 3): errors with these estimates at the end (mm, deg) and along the way (mm) of each log."""
    paths = ways(fit)(estimates[None], logs)[0]
    found = [
        errors(path, measured(fit.logs[i], fit.compared(fit.logs[i]))) for i, path in zip(logs, paths, strict=True)
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
            axes.plot(*path.position.T, color=colour, lw=1.3, label=f"{label}: {end:.0f} mm")
            axes.plot(*path.position[-1], "o", color=colour, ms=5)
        axes.plot(*way.position.T, color="#1f2933", lw=4, alpha=0.2, zorder=0, label="measured")
        axes.plot(*way.position[-1], "o", color="#1f2933", ms=9, alpha=0.3, zorder=0)
        axes.set(xlabel="x / m", ylabel="y / m", title=f"{other} {run}, by what {kind} tell")
        axes.set_aspect("equal", adjustable="datalim")
        axes.legend(frameon=False, fontsize=8, loc="center", title="off at the end", title_fontsize=8)
    figure.savefig(PICTURE, dpi=110)


def main(what: str) -> None:
    """The picture; or what ideal kinematics does, printed."""
    if what == "picture":
        return draw()
    for name in ("squares", "circles", "squares_mended", "circles_mended"):
        told = ideal(name, "circles" if "squares" in name else "squares")
        print(name, *(f"{key} {np.round(value, 2).tolist()}" for key, value in told.items()), sep="\n  ", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
