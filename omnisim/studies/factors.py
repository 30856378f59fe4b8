"""What a study varies: each key of [vary], the places in the scene that it sets, and the values that it may have."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from statistics import NormalDist
from typing import Any

from pydantic import ValidationError

from omnisim.scene.problems import Problem, misplaced, schema_problems
from omnisim.scene.scene import SceneError, with_index
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import KeyPath, show_value, split_key
from omnisim.scene.validation import tuples
from omnisim.studies.schema import VARIES, Variation

ALL = "*"
MANY = ("wheels", "wheel_types")  # tables of which a * stands for all
INSIDE = 2.0**-53  # of a probability: a normal distribution has no value at 0 and 1


@dataclass(frozen=True)
class Factor:
    """A varied key. targets: paths in the scene's data; names: what its * stands for, empty without one; each: every
    target has a draw of its own; values: a list of them, or a distribution."""

    key: str
    targets: tuple[KeyPath, ...]
    names: tuple[str, ...]
    each: bool
    values: "tuple[Any, ...] | Distribution"

    @property
    def listed(self) -> tuple[Any, ...]:
        """The values of a list."""
        if isinstance(self.values, Distribution):
            raise TypeError(f"{self.key} is drawn")
        return self.values

    @property
    def draws(self) -> int:
        """Numbers that a point of the design takes from it."""
        return len(self.targets) if self.each else 1

    def at(self, shares: Sequence[float]) -> list[Any]:
        """The values at shares of the whole, 0 to 1: of a distribution its quantiles."""
        if isinstance(self.values, Distribution):
            return self.values.quantiles(shares)
        values, count = self.values, len(self.values)
        return [values[min(int(share * count), count - 1)] for share in shares]


@dataclass(frozen=True)
class Distribution:
    """normal (mean, deviation), uniform (a, b), loguniform (a, b), or integers (a, b) with both ends."""

    kind: str
    a: float
    b: float

    def quantiles(self, shares: Sequence[float]) -> list[float | int]:
        """The values at shares of the whole, 0 to 1; by Python's own numbers, of one as of many the same bits."""
        a, b = self.a, self.b
        if self.kind == "normal":
            inverse = NormalDist(a, b).inv_cdf
            return [inverse(min(max(share, INSIDE), 1.0 - INSIDE)) for share in shares]
        if self.kind == "integers":
            return [min(int(a) + int(share * (b - a + 1)), int(b)) for share in shares]
        if self.kind == "loguniform":
            first, whole = math.log(a), math.log(b) - math.log(a)
            return [math.exp(first + share * whole) for share in shares]
        return [a + share * (b - a) for share in shares]


def factors(vary: Mapping[str, Any], data: dict[str, Any], sampled: bool) -> Iterator[Factor | Problem]:
    """The Factor of each key of [vary], or what is wrong with it; data: of the scene; sampled: the design draws."""
    for key, entry in vary.items():
        try:
            targets, names = places(key, data)
        except ValueError as error:
            yield Problem(("vary", key), str(error))
            continue
        found = list(possible(key, entry, sampled))
        problems = [problem for problem in found if isinstance(problem, Problem)]
        if problems:
            yield from problems
            continue
        values = found[0]
        each = isinstance(entry, Mapping) and bool(entry.get("each"))
        if each and not names:
            yield Problem(("vary", key, "each"), f"a draw for everything that a {ALL} stands for, and there is none")
        elif each and not sampled:
            yield Problem(("vary", key, "each"), 'takes a design that draws: "random", "sobol" or "latin"')
        elif problem := unfit(key, targets, values, data):
            yield problem
        else:
            yield Factor(key, targets, names, each, values)


def places(key: str, data: dict[str, Any]) -> tuple[tuple[KeyPath, ...], tuple[str, ...]]:
    """The paths that a dotted key stands for, and the names of its *. Raises ValueError for one that no scene has."""
    try:
        path = split_key(re.sub(r"(?<=\.)\*(?=\.|$)", f'"{ALL}"', key))
    except ValueError:
        raise ValueError("must be a dotted key of the scene in quotes") from None
    names: tuple[str, ...] = ()
    if len(path) > 1 and path[1] == ALL and path[0] in MANY:
        table = data[path[0]]
        names = tuple(table) if path[0] == "wheel_types" else tuple(wheel["name"] for wheel in table)
    if ALL in path[2 if names else 0 :]:
        raise ValueError(f"a {ALL} stands for all of {' or '.join(MANY)}, in their place")
    paths = [(path[0], name, *path[2:]) for name in names] or [path]
    try:
        targets = tuple(with_index(data, one, "vary") for one in paths)
    except SceneError as error:
        raise ValueError(str(error).removeprefix("vary: ")) from None
    for target in targets:
        if target[0] == "wheel_types" and len(target) > 1 and target[1] not in data["wheel_types"]:
            raise ValueError(f"no wheel type is called '{target[1]}'. Wheel types: {', '.join(data['wheel_types'])}")
        if problem := misplaced(target):
            raise ValueError(problem.message)
    return targets, names


def possible(key: str, entry: Any, sampled: bool) -> Iterator[Any]:
    """The values or the distribution of one entry of [vary], or Problems."""
    here = ("vary", key)
    if isinstance(entry, Sequence) and not isinstance(entry, str):
        if not entry:
            yield Problem(here, "must have one value or more")
        else:
            yield tuple(entry)
        return
    if not isinstance(entry, Mapping):
        yield Problem(here, f"must be {VARIES}")
        return
    try:
        varied = Variation.model_validate(tuples(entry))
    except ValidationError as error:
        if not set(entry) & set(schema_names()) and all(
            isinstance(value, list | tuple | dict) for value in entry.values()
        ):
            yield Problem(
                here, f'must be {VARIES}; a dotted key stands in quotes, such as "{key}.{next(iter(entry), "")}"'
            )
        else:
            yield from (
                problem._replace(path=here + problem.path) for problem in schema_problems(error, entry, Variation)
            )
        return
    yield from spread(here, varied, sampled)


def schema_names() -> list[str]:
    return [field.alias or name for name, field in Variation.model_fields.items()]


def spread(here: KeyPath, varied: Variation, sampled: bool) -> Iterator[Any]:
    """The same of a table."""
    given = varied.model_fields_set - {"each"}
    ranged = {"first", "last", "count", "spacing"}
    if given and given <= ranged:
        yield from ranges(here, varied, sampled)
    elif given == {"mean", "deviation"} and varied.mean is not None and varied.deviation is not None:
        yield from (Distribution("normal", varied.mean, varied.deviation),)
    elif given == {"uniform"} and varied.uniform:
        yield (
            Distribution("uniform", *varied.uniform)
            if varied.uniform[0] < varied.uniform[1]
            else Problem((*here, "uniform"), "must be [least, most], the first below the second")
        )
    elif given == {"loguniform"} and varied.loguniform:
        yield (
            Distribution("loguniform", *varied.loguniform)
            if 0 < varied.loguniform[0] < varied.loguniform[1]
            else Problem((*here, "loguniform"), "must be [least, most], both > 0, the first below the second")
        )
    else:
        yield Problem(here, f"must be {VARIES}, and nothing else")


def ranges(here: KeyPath, varied: Variation, sampled: bool) -> Iterator[Any]:
    """The values from `from` to `to`; in a design that draws and without a count, all between them."""
    first, last, count = varied.first, varied.last, varied.count
    if first is None or last is None or not first < last:
        yield Problem(here, "must have from and to, the first below the second")
        return
    whole = isinstance(first, int) and isinstance(last, int)
    logarithmic = varied.spacing == "log"
    if logarithmic and first <= 0:
        yield Problem((*here, "from"), 'must be > 0 where spacing is "log"')
    elif count is None and whole and not logarithmic:
        yield Distribution("integers", first, last) if sampled else tuple(range(int(first), int(last) + 1))
    elif count is None and sampled:
        yield Distribution("loguniform" if logarithmic else "uniform", first, last)
    elif count is None or count < 2:
        yield Problem((*here, "count"), "must be 2 or more between numbers that are not integers")
    else:
        between = Distribution("loguniform" if logarithmic else "uniform", first, last)
        yield (float(first), *between.quantiles([i / (count - 1) for i in range(1, count - 1)]), float(last))


def unfit(key: str, targets: Sequence[KeyPath], values: Any, data: dict[str, Any]) -> Problem | None:
    """The first value of a list that a scene could never have at this key, whatever else it says."""
    if isinstance(values, Distribution):
        return None
    for value in values:
        trial = with_values(data, [(target, value) for target in targets])
        try:
            Config.model_validate(tuples(trial))
        except ValidationError as error:
            for problem in schema_problems(error, trial):
                if any(problem.path[: len(target)] == target for target in targets):
                    return Problem(("vary", key), f"{show_value(value)}: {problem.message}")
    return None


def drawn_values(varied: Sequence[Factor], shares: Iterable[float]) -> list[list[Any]]:
    """The values of each factor by shares of the whole, 0 to 1: one, or one for each of its targets."""
    left = iter(shares)
    return [factor.at(list(islice(left, factor.draws))) for factor in varied]


def settings(varied: Sequence[Factor], values: Sequence[Sequence[Any]]) -> list[tuple[KeyPath, Any]]:
    """The paths in the scene's data that such values set, and what each is set to."""
    found: list[tuple[KeyPath, Any]] = []
    for factor, own in zip(varied, values, strict=True):
        found += zip(factor.targets, own if factor.each else [*own] * len(factor.targets), strict=True)
    return found


def with_values(data: Any, values: Sequence[tuple[KeyPath, Any]]) -> Any:
    """The data of a scene with these values; only what contains them is new."""
    below: dict[Any, list[tuple[KeyPath, Any]]] = {}
    for path, value in values:
        if not path:
            data, below = value, {}
        else:
            below.setdefault(path[0], []).append((path[1:], value))
    if not below:
        return data
    if isinstance(data, dict):
        return data | {key: with_values(data.get(key, {}), own) for key, own in below.items()}
    changed = list(data)
    for index, own in below.items():
        changed[int(index)] = with_values(changed[int(index)], own)
    return type(data)(changed)
