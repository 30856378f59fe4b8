"""The numbers that a study asks of each run: datasets of the trajectory, at one time or reduced over all."""

from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, Protocol

import numpy as np

from omnisim.results.layout import AXIS, HUB, LABELS, MOUNT, PLANE, TANGENT, TIME, Quantity, layout
from omnisim.results.ripple import RippleError, spectrum
from omnisim.scene.problems import Problem, did_you_mean
from omnisim.scene.schema import Config
from omnisim.studies.schema import Measure

NORM, END = "norm", "end"
MOST, LEAST = "interval_max", "interval_min"
EXTREMES = {"max": (MOST,), "min": (LEAST,), "ptp": (MOST, LEAST)}  # what the march itself has followed
ALIASES = {"odometry/error": "odometry/position_error"}
DIRECTIONS = (AXIS, PLANE, TANGENT, HUB, MOUNT)
FINAL = ("body/position", "body/yaw", "body/velocity", "body/yaw_rate", "wheels/*/spin_angle", "wheels/*/spin_rate")
ON_GRID = 1e-9  # relative, of times that must be those of rows


class NoNumber(ValueError):
    """Why a run has no number of a measure."""


class Datasets(Protocol):
    """A trajectory, or what computes its datasets when they are asked for."""

    def __getitem__(self, path: str) -> np.ndarray: ...


@dataclass(frozen=True)
class Reading:
    """A measure of a scene.

    paths: its datasets, one for each wheel that a * stands for; component: which of their last axis, or NORM, or None
    where it has no directions; time: where it is read, s or END, None if of all rows; reduce: None if there is nothing
    to reduce; followed: the extremes of the march tell it, rows need not.
    """

    name: str
    units: str
    paths: tuple[str, ...]
    component: Any
    time: float | str | None
    reduce: str | None
    followed: bool

    @property
    def told(self) -> str:
        """What it is, in words."""
        parts = [self.paths[0] if len(self.paths) == 1 else f"{self.paths[0]} and those of the other wheels"]
        if self.component is not None:
            parts.append(str(self.component) if self.component == NORM else f"component {self.component}")
        if self.time is not None:
            parts.append("at the end" if self.time == END else f"at {self.time:g} s")
        if self.reduce:
            parts.append(f"{self.reduce} of {'the march' if self.followed else 'rows'}")
        return ", ".join(parts)

    def follows(self, folder: str) -> bool:
        """Whether it asks for what the march follows of a dataset in this folder."""
        path = self.paths[0]
        return (self.followed and path.startswith(folder)) or path.startswith((f"{MOST}/{folder}", f"{LEAST}/{folder}"))

    def of(self, found: Datasets, config: Config) -> float:
        """Its value in a complete run of this scene. Raises NoNumber where there is none."""
        if self.followed:
            groups = EXTREMES[self.reduce or ""]
            return reduced(self.reduce, np.array([found[f"{group}/{path}"] for group in groups for path in self.paths]))
        if self.time is not None:
            row = row_at(self.time, config)
            return reduced(self.reduce, np.array([self.part(found[path][row]) for path in self.paths]))
        rows = np.array([self.part(found[path]) for path in self.paths])  # (wheels, T, ...)
        if self.reduce == "ripple":
            return self.ripple(rows, found, config)
        return reduced(self.reduce, np.moveaxis(rows, 1, -1), durations(found[TIME]))

    def part(self, array: np.ndarray) -> np.ndarray:
        """The component, or the length, of a dataset."""
        if self.component is None:
            return array
        return np.sqrt(np.add.reduce(array * array, axis=-1)) if self.component == NORM else array[..., self.component]

    def ripple(self, rows: np.ndarray, found: Datasets, config: Config) -> float:
        """RMS over the wheels of what repeats with every roller, or with every roller of a row: of a wheel's dataset
        with its own, of any other with those of the first wheel."""
        squares = []
        for path, values in zip(self.paths, rows, strict=True):
            name = path.split("/")[1] if path.startswith("wheels/") else config.wheels[0].name
            wheel = next(wheel for wheel in config.wheels if wheel.name == name)
            angle, kind = found[f"wheels/{name}/spin_angle"], config.type_of(wheel)
            count = len(kind.rows)
            try:
                orders, amplitudes = spectrum(angle, kind.rollers, values, count)
            except RippleError as error:
                raise NoNumber(f"wheel '{name}' {error}") from None
            whole = [amplitudes[np.argmin(np.abs(orders - (i + 1) / count))] for i in range(count)]
            squares.append(0.5 * np.sum(np.square(whole)))
        return float(np.sqrt(np.mean(squares)))


def row_at(time: float | str, config: Config) -> int:
    """The row of a time, s. Raises NoNumber where there is none."""
    if isinstance(time, str):
        return -1
    interval = config.time.output_interval
    row = round(time / interval)
    if row > config.time.outputs or abs(time - row * interval) > ON_GRID * max(time, interval):
        raise NoNumber(f'must be "end" or a multiple of time.output_interval = {interval:g} up to time.end')
    return row


def durations(times: np.ndarray) -> np.ndarray:
    """Weights (T,) of the trapezoidal rule, s; 1 of a single row."""
    if len(times) == 1:
        return np.ones(1)
    weights = np.full(len(times), times[1] - times[0])
    weights[[0, -1]] *= 0.5
    return weights


def reduced(how: str | None, values: np.ndarray, weights: np.ndarray | None = None) -> float:
    """One number of `values`: means and integrals over their last axis with these weights, and over wheels and rollers
    without; the integral is summed over them."""
    if how in (None, "max", "min"):
        return float(values.item() if how is None else np.max(values) if how == "max" else np.min(values))
    if how == "ptp":
        return float(np.ptp(values))
    if how == "integral":
        return float(np.sum(values @ weights))
    squares = values**2 if how == "rms" else values
    mean = float(np.mean(squares if weights is None else squares @ weights / np.sum(weights)))
    return float(np.sqrt(mean)) if how == "rms" else mean


def readings(asked: dict[str, Measure], config: Config, known: frozenset[str]) -> Iterator[Reading | Problem]:
    """The Reading of each measure, or what is wrong with it; known: paths of all datasets of this scene."""
    for name, measure in asked.items():
        found = list(_reading(name, measure, config, known))
        problems = [entry for entry in found if isinstance(entry, Problem)]
        yield from problems[:1] or found


def _reading(name: str, measure: Measure, config: Config, known: frozenset[str]) -> Iterator[Reading | Problem]:
    """First what is wrong, if anything is, then the Reading."""
    here = ("measure", name)
    pattern = ALIASES.get(measure.dataset, measure.dataset).strip("/")
    wheels = tuple(wheel.name for wheel in config.wheels)
    several = pattern.startswith("wheels/*/")
    paths = tuple(pattern.replace("*", wheel, 1) for wheel in wheels) if several else (pattern,)
    quantity = layout(wheels).get(paths[0])
    if quantity is None or not known.issuperset(paths):
        yield Problem((*here, "dataset"), _unknown(pattern, wheels, known))
        return
    if quantity.axes[0] != TIME or quantity.dtype == "str":
        yield Problem((*here, "dataset"), "must be a dataset of numbers along time")
        return
    yield from _faults(here, measure, quantity, several, config)
    directions = LABELS[quantity.axes[-1]] if quantity.axes[-1] in DIRECTIONS else ()
    component = measure.component
    if isinstance(component, str) and component in directions:
        component = directions.index(component)
    ends = EXTREMES.get(measure.reduce or "", ()) if measure.at is None else ()
    followed = bool(ends) and known.issuperset(f"{group}/{path}" for group in ends for path in paths)
    followed = followed and component == (NORM if directions else None)
    units = f"{quantity.units} s" if measure.reduce == "integral" else quantity.units
    yield Reading(name, units, paths, component, measure.at, measure.reduce, followed)


def _faults(
    here: tuple[str, str], measure: Measure, quantity: Quantity, several: bool, config: Config
) -> Iterator[Problem]:
    """What does not go together in a measure."""
    axis = quantity.axes[-1]
    directions = LABELS[axis] if axis in DIRECTIONS else ()
    component, at, how = measure.component, measure.at, measure.reduce
    if directions and component not in (NORM, *directions, *range(len(directions))):
        yield Problem((*here, "component"), f"must be one of {NORM}, {', '.join(directions)}")
    if not directions and component is not None:
        yield Problem((*here, "component"), "this dataset has no directions")
    if isinstance(at, str) and at != END:
        yield Problem((*here, "at"), 'must be "end" or a time, s')
    elif at is not None:
        try:
            row_at(at, config)
        except NoNumber as error:
            yield Problem((*here, "at"), str(error))
    rollers = len(quantity.axes) - bool(directions) > 1
    if at is None and how is None:
        yield Problem(here, "must say at which time, or how to reduce all of them: at, reduce")
    elif at is not None and how in ("integral", "ripple"):
        yield Problem((*here, "reduce"), "needs all times, and at says one")
    elif how is None and (several or rollers):
        yield Problem(here, f"must have a reduce, as there are several {'wheels' if several else 'rollers'}")
    elif how == "ripple" and rollers:
        yield Problem((*here, "reduce"), "cannot be of every roller")


def _unknown(pattern: str, wheels: tuple[str, ...], known: frozenset[str]) -> str:
    """What to say of a dataset that the scene does not have."""
    first, _, rest = pattern.partition("/")
    name, _, path = rest.partition("/")
    if first == "wheels" and name != "*" and name not in wheels:
        return f"no wheel is called '{name}'{did_you_mean(name, wheels) or '.'} Wheels: {', '.join(wheels)}, or *"
    shared = {
        path.replace(f"wheels/{wheels[0]}/", "wheels/*/")
        for path in known
        if path.partition("/")[0] not in (MOST, LEAST)
    }
    wanted = f"wheels/*/{path}" if first == "wheels" else pattern
    near = get_close_matches(wanted, sorted(shared), n=5, cutoff=0.4)
    return f"no dataset of this scene; near: {', '.join(near)}" if near else "no dataset of this scene"


def last_values(config: Config) -> Iterator[Reading]:
    """Readings of the state in the last row, named by its datasets."""
    wheels = tuple(wheel.name for wheel in config.wheels)
    table = layout(wheels)
    for pattern in FINAL:
        for path in dict.fromkeys(pattern.replace("*", wheel) for wheel in wheels):
            axis = table[path].axes[-1]
            name = "final." + path.replace("/", ".")
            directions = LABELS[axis] if axis in DIRECTIONS else ()
            for i, label in enumerate(directions):
                yield Reading(f"{name}.{label}", table[path].units, (path,), i, END, None, False)
            if not directions:
                yield Reading(name, table[path].units, (path,), None, END, None, False)
