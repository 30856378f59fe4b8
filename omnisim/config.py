"""The scene file as frozen models: its keys, their defaults and bounds, and every rule that a scene obeys.

Values keep the units of the file (SI, degrees where a key ends in `_deg`). The text that says what a key may
be is the `description` of its field and stands nowhere else. Schema first (pydantic), then the rules across
keys at the bottom of this file. A key or word that a later version learns moves from NOT_YET to the models.
"""

import difflib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic.fields import FieldInfo

from omnisim.toml_text import MISSING, KeyPath, value_at

MAX_STEPS = 10**10
MAX_ROLLERS = 10**6  # far beyond any wheel; keeps N_r an integer that floats and arrays can hold
GRID_TOLERANCE = 1e-9  # relative, for ratios of times that must be integers
DECIMAL_TOLERANCE = 1e-12  # relative, for limits that a scene reaches exactly but types in decimals
NAME = "[A-Za-z][A-Za-z0-9_-]*"


class Problem(NamedTuple):
    """One defect of a scene: the key it is about (wheels and entries by index), and what is allowed."""

    path: KeyPath
    message: str


class ConfigError(ValueError):
    """All `problems` found in a scene; the caller knows the text and can say where they stand."""

    def __init__(self, problems: Iterable[Problem]):
        self.problems = tuple(problems)
        super().__init__("\n".join(f"{problem.path}: {problem.message}" for problem in self.problems))


# --- values ---------------------------------------------------------------------------------------


def _choice(*words: str) -> Any:
    return Annotated[Literal[words], Field(description=_join(words))]


def _join(words: Iterable[str]) -> str:
    *most, last = [f'"{word}"' for word in words]
    return f"{', '.join(most)} or {last}" if most else last


# Which keys a friction law reads; the values that some of them have when absent.
FRICTION_KEYS = {
    "regularized": ("coefficient", "slip_speed"),
    "saturated": ("coefficient", "slip_speed"),
    "viscous": ("viscosity",),
    "none": (),
}
FRICTION_DEFAULTS = {"saturated": {"slip_speed": 1e-6}}
DRIVE_KEYS = {"free": (), "torque": ("times", "torque")}

Real = Annotated[float, Field(description="a finite number")]
Positive = Annotated[float, Field(gt=0, description="a finite number > 0")]
Interval = Annotated[float | None, Field(gt=0, description="a finite number > 0")]
NonNegative = Annotated[float, Field(ge=0, description="a finite number >= 0")]
Boolean = Annotated[bool, Field(description="true or false")]
Name = Annotated[
    str, Field(pattern=f"^{NAME}$", description="a name (a letter, then letters, digits, _ or -)")
]
Count = Annotated[int, Field(ge=3, le=MAX_ROLLERS, description=f"an integer from 3 to {MAX_ROLLERS}")]
Planar = Annotated[tuple[float, float], Field(description="two finite numbers [x, y]")]
Reals = Annotated[tuple[float, ...], Field(min_length=1, description="a list of one or more finite numbers")]
Rates = Annotated[
    float | tuple[float, ...],
    Field(description="one finite number, or a list of roller_count finite numbers"),
]
Torque = Annotated[
    float | tuple[float, ...],
    Field(description="a finite number or, with times, a list of as many finite numbers"),
]
Vectors = Annotated[
    tuple[tuple[float, float, float], ...],
    Field(min_length=1, description="a list of one or more vectors [x, y, z] of finite numbers"),
]


# --- tables of the file ---------------------------------------------------------------------------


class Table(BaseModel):
    """Integers pass for numbers; booleans, strings, NaN, infinities and unknown keys never do."""

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)


class World(Table):
    """[scene]: gravity in m/s^2, and what carries roll and pitch."""

    gravity: NonNegative = 9.81
    upright: _choice("servo") = "servo"


class Time(Table):
    """[time]: end and fixed step (s), and the grid of output that follows from them."""

    end: Positive
    step: Positive
    interval: Interval = Field(None, alias="output_interval")  # None: chosen below

    @property
    def steps_per_output(self) -> int:
        """Steps of one output interval; by default a divisor of all steps that leaves about 100 intervals."""
        if self.interval is not None:
            return round(self.interval / self.step)
        steps = round(self.end / self.step)
        return steps // _about_100(steps)

    @property
    def output_interval(self) -> float:
        """Time between two rows of output, s."""
        return self.steps_per_output * self.step if self.interval is None else self.interval

    @property
    def outputs(self) -> int:
        """Number of output intervals: one less than rows."""
        return round(self.end / self.output_interval)

    @property
    def steps(self) -> int:
        """Number of steps of the whole run."""
        return self.outputs * self.steps_per_output


class Solver(Table):
    """[solver]: Runge-Kutta method, and which of the two contact tracking algorithms runs."""

    method: _choice("heun", "rk4", "dopri5") = "rk4"
    tracking: _choice("explicit", "implicit") = "explicit"


class Friction(Table):
    """[friction]: a law, and the numbers it reads (slip_speed in m/s, viscosity in N s/m; 0 where absent)."""

    law: _choice(*FRICTION_KEYS)
    coefficient: NonNegative = 0.0
    slip_speed: Positive = 0.0
    viscosity: NonNegative = 0.0

    @model_validator(mode="before")
    @classmethod
    def _defaults_of_the_law(cls, data: Any) -> Any:
        law = data.get("law") if isinstance(data, dict) else None
        return FRICTION_DEFAULTS.get(law, {}) | data if isinstance(law, str) else data


class Disk(Table):
    """A wheel without its rollers: mass (kg), moments of inertia (kg m^2) about axle and diameter."""

    mass: Positive
    inertia_axle: Positive
    inertia_diameter: Positive


class Roller(Table):
    """One roller: mass (kg), moments of inertia (kg m^2) about its axis and across it."""

    mass: Positive
    inertia_axial: Positive
    inertia_transverse: Positive


class WheelType(Table):
    """[wheel_types.NAME]: radius R and roller distance R1 (m), N_r, psi (deg), disk and roller."""

    radius: Positive
    roller_distance: Positive
    roller_count: Count
    roller_angle_deg: Annotated[float, Field(gt=-90, lt=90, description="a finite number between -90 and 90")]
    disk: Disk
    roller: Roller


class Drive(Table):
    """drive of a wheel: nothing, or a torque (N m) about the axle, constant or linear between `times` (s)."""

    kind: _choice(*DRIVE_KEYS)
    times: Reals = ()
    torque: Torque = 0.0

    @property
    def table(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Times and torques; a constant is a table of one point, since tables are held outside."""
        return (self.times, self.torque) if self.times else ((0.0,), (self.torque,))


class Wheel(Table):
    """[[wheels]]: a wheel type put somewhere, its start and its drive (angles in deg, rates in rad/s)."""

    name: Name
    type: Annotated[str, Field(description="the name of a wheel type")]
    position: Planar = (0.0, 0.0)
    heading_deg: Real = 0.0
    mirrored: Boolean = False
    phase_deg: Real = 0.0
    spin_angle_deg: Real = 0.0
    spin_rate: Real = 0.0
    roller_rates: Rates = 0.0
    drive: Drive = Drive(kind="free")


class Wrench(Table):
    """[wrench]: force (N) and yaw torque (N m) on the body, linear between `times` (s)."""

    frame: _choice("world", "body") = "world"
    times: Reals = ()
    force: Vectors = ()
    yaw_torque: Reals = ()

    @property
    def table(self) -> tuple[tuple[float, ...], tuple[tuple[float, float, float], ...], tuple[float, ...]]:
        """Times, forces and yaw torques, equally long; zeros where the scene has none."""
        times = self.times or (0.0,)
        return times, self.force or ((0.0, 0.0, 0.0),) * len(times), self.yaw_torque or (0.0,) * len(times)


class Initial(Table):
    """[initial]: position (m), yaw (deg), velocity (m/s, world) and yaw rate (rad/s) at t = 0."""

    position: Planar = (0.0, 0.0)
    yaw_deg: Real = 0.0
    velocity: Planar = (0.0, 0.0)
    yaw_rate: Real = 0.0


class Config(Table):
    """A whole scene file. Made by `validate`, which also checks the rules across keys."""

    schema_version: Annotated[int, Field(ge=1, le=1, alias="schema", description="1")]
    title: Annotated[str, Field(description="a string")] = ""
    world: World = Field(World(), alias="scene")
    time: Time
    solver: Solver = Solver()
    friction: Friction
    wheel_types: Annotated[
        dict[Name, WheelType], Field(min_length=1, description="one or more tables [wheel_types.NAME]")
    ]
    wheels: Annotated[tuple[Wheel, ...], Field(min_length=1, description="one or more tables [[wheels]]")]
    wrench: Wrench = Wrench()
    initial: Initial = Initial()

    def type_of(self, wheel: Wheel) -> WheelType:
        return self.wheel_types[wheel.type]


# Keys and words of the contract that this version does not simulate: path, words (none: anything there), and
# what it has instead (None: the field says).
ONE_BARE_WHEEL = "it simulates one wheel without a chassis"
NOT_YET = (
    (("chassis",), (), ONE_BARE_WHEEL),
    (("wheels", 1), (), ONE_BARE_WHEEL),
    (("scene", "upright"), ("contacts",), None),
    (("solver", "method"), ("radau5", "auto"), None),
    (("friction", "law"), ("coulomb",), None),
)


def validate(data: Mapping[str, Any]) -> Config:
    """The scene in `data` (what tomllib returns), or ConfigError with every problem found."""
    data = _tuples(data)
    problems = list(_not_yet(data))
    try:
        config = Config.model_validate(data)
    except ValidationError as error:
        known = {problem.path for problem in problems}
        problems += (problem for problem in _schema_problems(error, data) if problem.path not in known)
    if not problems:  # rules compare values, so the values come first
        problems = [problem for rule in RULES for problem in rule(config)]
    if problems:
        raise ConfigError(problems)
    return config


def unused_keys(config: Config) -> tuple[str, ...]:
    """Dotted keys that nothing reads: those of other friction laws, wheel types without a wheel."""
    friction = config.friction.model_fields_set - {"law", *FRICTION_KEYS[config.friction.law]}
    types = set(config.wheel_types) - {wheel.type for wheel in config.wheels}
    unread = (("friction", friction), ("wheel_types", types))
    return tuple(f"{table}.{key}" for table, keys in unread for key in sorted(keys))


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """A hint to append to a message, or nothing."""
    close = _closest(word, known)
    return f"; did you mean '{close}'?" if close else ""


def _closest(word: Any, known: Iterable[str]) -> str | None:
    known = {name.lower(): name for name in known}
    close = difflib.get_close_matches(str(word).lower(), list(known), 1)
    return known[close[0]] if close else None


def _tuples(value: Any) -> Any:
    """Lists become tuples: strict models take no list for a tuple, and frozen ones should hold none."""
    if isinstance(value, dict):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(_tuples(entry) for entry in value) if isinstance(value, list) else value


# --- schema problems: what pydantic finds, in the words of the scene file -------------------------


class _Place(NamedTuple):
    """Where a pydantic location lands in the models: `rest` is what lies deeper than any key."""

    path: KeyPath
    table: type[Table]  # that the last key of the path belongs to
    field: FieldInfo | None  # that it names; None when unknown
    nested: type[Table] | None  # the table that stands there
    rest: KeyPath


def _place(location: KeyPath) -> _Place:
    table, field, nested, path, rest = Config, None, Config, (), location
    while rest and nested:
        table, path, rest = nested, (*path, rest[0]), rest[1:]
        field = _fields(table).get(path[-1])
        nested, many = _nested(field.annotation) if field else (None, False)
        if many and rest:
            path, rest = (*path, rest[0]), rest[1:]
        elif many:
            nested = None
    return _Place(path, table, field, nested, rest)


def _fields(table: type[Table]) -> dict[str, FieldInfo]:
    return {field.alias or name: field for name, field in table.model_fields.items()}


def _nested(annotation: Any) -> tuple[type[Table] | None, bool]:
    """The table that a field holds, and whether it holds many of them."""
    for part in (annotation, *get_args(annotation)):
        if isinstance(part, type) and issubclass(part, Table):
            return part, get_origin(annotation) in (tuple, dict)
    return None, False


def _allowed(place: _Place) -> str:
    if place.nested:
        return f"a table with the keys {', '.join(_fields(place.nested))}"
    return place.field.description


def _schema_problems(error: ValidationError, data: Any) -> Iterator[Problem]:
    items = [(item["type"], item["loc"]) for item in error.errors(include_url=False, include_input=False)]
    # Missing keys that an unknown one nearly spells are no second defect.
    unknown = [location for kind, location in items if kind == "extra_forbidden"]
    meant = {(*path[:-1], _closest(path[-1], _fields(_place(path).table))) for path in unknown}
    for location in _deepest(location for _, location in items):
        place = _place(location)
        if location in unknown:
            yield _unknown_key(place)
        elif location[-1] == "[key]":
            yield Problem(location[:-1], f"must be {get_args(Name)[1].description}")
        elif value_at(data, place.path) is not MISSING:
            yield _wrong_value(data, place)
        elif place.path not in meant:
            yield Problem(place.path, f"missing; must be {_allowed(place)}")


def _unknown_key(place: _Place) -> Problem:
    known = _fields(place.table)
    hint = did_you_mean(place.path[-1], known) or "."
    return Problem(place.path, f"unknown key{hint} Allowed: {', '.join(known)}")


def _deepest(locations: Iterable[KeyPath]) -> Iterable[KeyPath]:
    """One location for each defect: the deepest. A union reports once for every type that it tried, and a
    list of tables that it is too short when the tables in it are wrong."""
    best: dict[KeyPath, KeyPath] = {}
    for location in sorted(locations, key=len, reverse=True):
        best.setdefault(_place(location).path, location)
    parents = {path[:end] for path in best for end in range(len(path))}
    return [location for path, location in best.items() if path not in parents]


def _wrong_value(data: Any, place: _Place) -> Problem:
    path = place.path
    for index in (part for part in place.rest if isinstance(part, int)):
        if value_at(data, (*path, index)) is not MISSING:
            path = (*path, index)
    value, hint = value_at(data, path), ""
    if isinstance(value, str):
        if get_origin(place.field.annotation) is Literal:
            hint = did_you_mean(value, get_args(place.field.annotation))
        elif "number" in _allowed(place) and (number := _number_in(value)) is not None:
            hint = f"; did you mean {number}?"
    return Problem(path, f"must be {_allowed(place)}{hint}")


def _number_in(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _not_yet(data: Any) -> Iterator[Problem]:
    for path, words, instead in NOT_YET:
        value = value_at(data, path)
        if value is not MISSING and (not words or value in words):
            yield Problem(path, f"not in this version; {instead or f'must be {_allowed(_place(path))}'}")


# --- rules across keys ----------------------------------------------------------------------------


def _time_rules(config: Config) -> Iterator[Problem]:
    time = config.time
    steps = time.end / time.step
    if steps > MAX_STEPS * (1 + GRID_TOLERANCE):
        yield Problem(("time", "step"), f"end / step = {steps:.6g} steps; must be at most {MAX_STEPS:.0e}")
    elif time.interval is None:
        if not _is_whole(steps):
            ratio = f"end / step = {time.end!r} / {time.step!r} = {steps:.12g}"
            yield Problem(("time", "step"), f"{ratio}; must be an integer (to 1e-9)")
    else:
        ratios = {
            f"output_interval / step = {time.interval!r} / {time.step!r}": time.interval / time.step,
            f"end / output_interval = {time.end!r} / {time.interval!r}": time.end / time.interval,
        }
        for name, ratio in ratios.items():
            if not _is_whole(ratio):
                yield Problem(
                    ("time", "output_interval"), f"{name} = {ratio:.12g}; must be an integer (to 1e-9)"
                )
                break  # one of the three times is wrong: one problem


def _is_whole(ratio: float) -> bool:
    return math.isfinite(ratio) and ratio > 0.5 and abs(ratio - round(ratio)) <= GRID_TOLERANCE * ratio


@lru_cache(maxsize=16)
def _about_100(steps: int) -> int:
    """The divisor of `steps` nearest to 100 in the logarithm. No tie: two as near make 100 a divisor too."""
    small = [d for d in range(1, math.isqrt(steps) + 1) if steps % d == 0]
    return min((*small, *(steps // d for d in small)), key=lambda d: max(d / 100, 100 / d))


def _friction_rules(config: Config) -> Iterator[Problem]:
    law = config.friction.law
    for key in FRICTION_KEYS[law]:
        if key not in config.friction.model_fields_set:
            allowed = _allowed(_place(("friction", key)))
            yield Problem(("friction", key), f"missing; law = '{law}' needs {allowed}")


def _wheel_type_rules(config: Config) -> Iterator[Problem]:
    """Tips with r(alpha) >= 0; rollers that a mass distribution can have (a flat disc is the limit)."""
    for name, wheel_type in config.wheel_types.items():
        path = ("wheel_types", name)
        limit = wheel_type.radius * math.cos(math.pi / wheel_type.roller_count)
        if wheel_type.roller_distance > limit * (1 + DECIMAL_TOLERANCE):
            allowed = f"radius * cos(pi / roller_count) = {limit!r}: there the tips of the rollers are points"
            yield Problem((*path, "roller_distance"), f"must be at most {allowed}")
        roller = wheel_type.roller
        limit = 2 * roller.inertia_transverse
        if roller.inertia_axial > limit * (1 + DECIMAL_TOLERANCE):
            allowed = f"2 * inertia_transverse = {limit!r}: no body has more"
            yield Problem((*path, "roller", "inertia_axial"), f"must be at most {allowed}")


def _wheel_rules(config: Config) -> Iterator[Problem]:
    names = [wheel.name for wheel in config.wheels]
    for index, wheel in enumerate(config.wheels):
        path = ("wheels", index)
        if wheel.name in names[:index]:
            yield Problem((*path, "name"), "must be unique; another wheel has this name")
        if wheel.type not in config.wheel_types:
            known = ", ".join(config.wheel_types)
            hint = did_you_mean(wheel.type, config.wheel_types)
            yield Problem((*path, "type"), f"no such wheel type{hint or '.'} Wheel types: {known}")
        elif isinstance(wheel.roller_rates, tuple):
            count, given = config.type_of(wheel).roller_count, len(wheel.roller_rates)
            if given != count:
                allowed = f"one finite number, or a list of roller_count = {count} finite numbers"
                yield Problem((*path, "roller_rates"), f"must be {allowed}, not {given}")
        yield from _drive_rules((*path, "drive"), wheel.drive)


def _bare_wheel_rules(config: Config) -> Iterator[Problem]:
    """Without a chassis a wheel stands where [initial] puts it, and nowhere else."""
    wheel = config.wheels[0]
    for key, value, zero, instead in (
        ("position", wheel.position, "[0, 0]", "position"),
        ("heading_deg", wheel.heading_deg, "0", "yaw_deg"),
    ):
        if value not in (0.0, (0.0, 0.0)):
            allowed = f"absent or {zero} for a wheel without a chassis; [initial] {instead} places it"
            yield Problem(("wheels", 0, key), f"must be {allowed}")


def _drive_rules(path: KeyPath, drive: Drive) -> Iterator[Problem]:
    for key in sorted(drive.model_fields_set - {"kind", *DRIVE_KEYS[drive.kind]}):
        yield Problem((*path, key), f"not a key of a drive with kind = '{drive.kind}'")
    if drive.kind == "free":
        return
    if "torque" not in drive.model_fields_set:
        yield Problem((*path, "torque"), f"missing; must be {_allowed(_place((*path, 'torque')))}")
    elif isinstance(drive.torque, float) and drive.times:
        allowed = f"a list of {len(drive.times)} finite numbers, as many as times"
        yield Problem((*path, "torque"), f"must be {allowed}")
    elif isinstance(drive.torque, tuple):
        if not drive.times:
            yield Problem((*path, "times"), "missing; a list of torques needs a list of as many times")
        else:
            yield from _table_rules(path, drive.times, torque=drive.torque)


def _wrench_rules(config: Config) -> Iterator[Problem]:
    wrench = config.wrench
    if wrench.times:
        yield from _table_rules(("wrench",), wrench.times, force=wrench.force, yaw_torque=wrench.yaw_torque)
    elif "wrench" in config.model_fields_set:
        yield Problem(("wrench", "times"), f"missing; must be {_allowed(_place(('wrench', 'times')))}")


def _table_rules(path: KeyPath, times: tuple[float, ...], **columns: tuple) -> Iterator[Problem]:
    for index in range(1, len(times)):
        if times[index] < times[index - 1]:
            allowed = f"at least {times[index - 1]!r}: times never decrease"
            yield Problem((*path, "times", index), f"must be {allowed}")
            break
    for key, column in columns.items():
        if column and len(column) != len(times):
            allowed = f"a list as long as times ({len(times)}), not {len(column)}"
            yield Problem((*path, key), f"must be {allowed}")


RULES = (_time_rules, _friction_rules, _wheel_type_rules, _wheel_rules, _bare_wheel_rules, _wrench_rules)


def is_name(word: Any) -> bool:
    """Whether a wheel or a wheel type may have this name."""
    return isinstance(word, str) and re.fullmatch(NAME, word) is not None
