"""The study file as frozen models: its keys, their defaults and bounds."""

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from omnisim.scene.values import Boolean, Name, NonNegative, PositiveOrNone, Real, Table, choice

MOST_RUNS = 10**8
REDUCTIONS = ("mean", "rms", "max", "min", "ptp", "integral", "ripple")

VARIES = "a list of values, { from, to }, { mean, deviation }, { uniform = [a, b] } or { loguniform = [a, b] }"

Number = Annotated[int | float | None, Field(description="a finite number")]
RealOrNone = Annotated[float | None, Field(description="a finite number")]
Interval = Annotated[tuple[Real, Real] | None, Field(description="two finite numbers [least, most]")]
Count = Annotated[int | None, Field(ge=1, le=MOST_RUNS, description=f"an integer from 1 to {MOST_RUNS}")]
Text = Annotated[str, Field(min_length=1, description="a text")]
if TYPE_CHECKING:  # to a type checker a word is a word
    Spacing = str
    Kind = str | None
    Reduction = str | None
    Trajectories = str
else:
    Spacing = choice("linear", "log")
    Kind = choice("grid", "zip", "random", "sobol", "latin", optional=True)
    Reduction = choice(*REDUCTIONS, optional=True)
    Trajectories = choice("none", "final", "all")


class Variation(Table):
    """How a key of [vary] varies: a range (from, to; count, spacing), or a distribution: normal (mean, deviation),
    uniform or loguniform. each: a draw of its own for everything that a * stands for."""

    first: Number = Field(None, alias="from")
    last: Number = Field(None, alias="to")
    count: Count = None
    spacing: Spacing = "linear"
    mean: RealOrNone = None
    deviation: PositiveOrNone = None
    uniform: Interval = None
    loguniform: Interval = None
    each: Boolean = False


class Design(Table):
    """[design]: how the varied keys make runs."""

    kind: Kind = None
    count: Count = None
    seed: Annotated[int, Field(ge=0, lt=2**63, description="an integer >= 0")] = 0


class Measure(Table):
    """[measure] NAME: a number of each run: of a dataset, at one time or reduced over all."""

    dataset: Text
    at: Annotated[NonNegative | str | None, Field(description='"end" or a time, s')] = None
    reduce: Reduction = None
    component: Annotated[str | int | None, Field(description='"norm", or the name or number of a component')] = None


class Keep(Table):
    """[keep]: what else is kept of each run."""

    trajectories: Trajectories = "none"


class StudyConfig(Table):
    """A whole study file; what stands under vary are lists of values, and tables that are a Variation each."""

    schema_version: Annotated[int, Field(ge=1, le=1, alias="schema", description="1")]
    scene: Text
    settings: Annotated[
        dict[str, Any], Field(alias="set", default_factory=dict, description="a table of keys of the scene")
    ]
    vary: Annotated[
        dict[str, Any], Field(min_length=1, description=f"a table of keys of the scene in quotes, each with {VARIES}")
    ]
    design: Design = Design()
    measure: Annotated[dict[Name, Measure], Field(default_factory=dict)]
    keep: Keep = Keep()
