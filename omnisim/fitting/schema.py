"""The fit file as frozen models: its keys, their defaults and bounds."""

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from omnisim.scene.values import Boolean, Positive, PositiveOrNone, Real, Table, choice

POSE = ("body/position.x", "body/position.y", "body/yaw")  # columns of the tracked point
TIME = "time"
MEASURED = ("angle", "angle_increment", "spin_rate")  # of a wheel, one of these

Text = Annotated[str, Field(min_length=1, description="a text")]
Column = Annotated[str | Annotated[int, Field(ge=0)], Field(description="the name of a column, or its number from 0")]
if TYPE_CHECKING:  # to a type checker a word is a word
    Use = str
else:
    Use = choice("fit", "test")


class LogEntry(Table):
    """[[logs]]: a file of rows, and which of its columns are what.

    columns: name or number of each; without it the header's names are those of the keys. scale: factors on columns.
    """

    file: Text
    use: Use = "fit"
    columns: Annotated[dict[str, Column], Field(default_factory=dict, description="a table of columns")]
    scale: Annotated[dict[str, Real], Field(default_factory=dict, description="a table of factors on columns")]


class Tracked(Table):
    """[tracked]: the point (m) and the heading (deg) that the logs have, in chassis axes."""

    x: Real = 0.0
    y: Real = 0.0
    yaw_deg: Real = 0.0


class Free(Table):
    """An entry of [free]: where its search starts, and between which ends it stays.

    scale: it is a factor on what the scene has. also: other keys that get the same value, or the same factor.
    """

    start: Real
    low: Real = Field(alias="from")
    high: Real = Field(alias="to")
    scale: Boolean = False
    also: Annotated[tuple[Text, ...], Field(description="a list of keys of the scene")] = ()


class Weights(Table):
    """[weights]: standard deviations of what is compared (m, rad), and the time between compared rows (s)."""

    position: Positive = Field(0.005, alias="body/position")
    yaw: Positive = Field(0.01, alias="body/yaw")
    every: PositiveOrNone = None


class FitConfig(Table):
    """A whole fit file."""

    schema_version: Annotated[int, Field(ge=1, le=1, alias="schema", description="1")] = 1
    scene: Text
    logs: Annotated[tuple[LogEntry, ...], Field(min_length=1, description="one or more tables [[logs]]")]
    tracked: Tracked = Tracked()
    free: Annotated[
        dict[str, Free],
        Field(min_length=1, description="a table of keys of the scene in quotes, each with { start, from, to }"),
    ]
    weights: Weights = Field(default_factory=lambda: Weights.model_validate({}))


def known_columns(wheels: tuple[str, ...]) -> list[str]:
    """Every column that a log of a machine with these wheels may have."""
    return [TIME, *POSE, *(f"wheels.{wheel}.{kind}" for wheel in wheels for kind in MEASURED)]
