"""What a value of a scene file may be: its type, its bounds and the words that say so; and a table of such values."""

import re
from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

MAX_ROLLERS = 10**6  # far beyond any wheel; keeps N_r an integer that floats and arrays can hold
NAME = "[A-Za-z][A-Za-z0-9_-]*"

Real = Annotated[float, Field(description="a finite number")]
RealOrNone = Annotated[float | None, Field(description="a finite number")]
Positive = Annotated[float, Field(gt=0, description="a finite number > 0")]
PositiveOrNone = Annotated[float | None, Field(gt=0, description="a finite number > 0")]
NonNegative = Annotated[float, Field(ge=0, description="a finite number >= 0")]
Slope = Annotated[float, Field(ge=0, lt=90, description="a finite number from 0 to less than 90")]
Boolean = Annotated[bool, Field(description="true or false")]
Name = Annotated[str, Field(pattern=f"^{NAME}$", description="a name (a letter, then letters, digits, _ or -)")]
Count = Annotated[int, Field(ge=3, le=MAX_ROLLERS, description=f"an integer from 3 to {MAX_ROLLERS}")]
Planar = Annotated[tuple[float, float], Field(description="two finite numbers [x, y]")]
Reals = Annotated[tuple[float, ...], Field(min_length=1, description="a list of one or more finite numbers")]
Rates = Annotated[
    float | tuple[float, ...],
    Field(description="one finite number, or a list of roller_count finite numbers"),
]
Tabulated = Annotated[
    float | tuple[float, ...],
    Field(description="a finite number or, with times, a list of as many finite numbers"),
]
Vectors = Annotated[
    tuple[tuple[float, float, float], ...],
    Field(min_length=1, description="a list of one or more vectors [x, y, z] of finite numbers"),
]
Twists = Annotated[
    tuple[tuple[float, float, float], ...],
    Field(min_length=1, description="a list of one or more twists [vx, vy, yaw_rate] of finite numbers"),
]
Point = Annotated[tuple[Real, Real, NonNegative], Field(description="three finite numbers [x, y, z], z >= 0")]
Bumps = Annotated[
    tuple[tuple[Real, Real, Real, Positive], ...],
    Field(description="a list of bumps [x, y, height, radius] of finite numbers, radius > 0"),
]
Spacing = Annotated[tuple[Positive, Positive], Field(description="two finite numbers > 0 [dx, dy]")]
Size = Annotated[
    tuple[Positive, Positive, Positive], Field(description="three finite numbers > 0 [length, width, height]")
]
Inertia = Annotated[tuple[Positive, Positive, Positive], Field(description="three finite numbers > 0 [Ixx, Iyy, Izz]")]


def choice(*words: str, optional: bool = False) -> Any:
    """One of these words; if optional, None stands for none of them."""
    kind: Any = Literal[words]
    return Annotated[kind | None if optional else kind, Field(description=join(words))]


def join(words: Iterable[str]) -> str:
    """The words in quotes, as an enumeration."""
    *most, last = [f'"{word}"' for word in words]
    return f"{', '.join(most)} or {last}" if most else last


class Table(BaseModel):
    """Integers pass for numbers; booleans, strings, NaN, infinities and unknown keys never do."""

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)


def is_name(word: Any) -> bool:
    """Whether a wheel or a wheel type may have this name."""
    return isinstance(word, str) and re.fullmatch(NAME, word) is not None
