"""What an environment may be told beside its scene and its path, and what holds where it is not."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, ValidationError

from omnisim.scene.document import sentence
from omnisim.scene.problems import schema_problems
from omnisim.scene.validation import tuples
from omnisim.scene.values import Boolean, NonNegative, Positive, Table, choice

if TYPE_CHECKING:  # to a type checker a word is a word
    Action = str
    Autoreset = str
else:
    Action = choice("torque", "rate", "twist")
    Autoreset = choice("NextStep", "Disabled")

Moments = Annotated[tuple[NonNegative, ...], Field(description="a list of finite numbers >= 0")]
Limits = Annotated[tuple[Positive, ...], Field(description="a list of finite numbers > 0")]
Tolerance = Annotated[tuple[Positive, Positive], Field(description="two finite numbers > 0 [m, rad]")]
Threads = Annotated[int | None, Field(ge=1, description="an integer >= 1")]


class Options(Table):
    """Options of the environment.

    action      what an action is: "torque" of each drive, target "rate" of each, or "twist" of the chassis
    limits      what an action of 1 means: N m, rad/s, or m/s, m/s and rad/s; one for each of its components, or one
                for all. Default: the standstill torque that the scene's drives have; the rate of 1 m/s at the rim;
                1 m/s, 1 m/s, 3 rad/s
    control     actions by second, Hz
    loads       whether the normal forces of the wheels are observed
    ahead       which poses of the path are observed beside the present one: so many seconds later each
    reach       distance from the path at which an episode ends as failed, m
    tolerance   distance (m) and angle (rad) at which the reward falls to 1/e
    autoreset_mode  "NextStep", or "Disabled": a vector environment begins no episode by itself
    threads     that share the machines of a vector environment; default: one for each core
    """

    action: Action = "twist"
    limits: Limits = ()
    control: Positive = 100.0
    loads: Boolean = False
    ahead: Moments = (0.1, 0.3)
    reach: Positive = 0.5
    tolerance: Tolerance = (0.1, 0.2)
    autoreset_mode: Autoreset = "NextStep"
    threads: Threads = None


def read(given: Mapping[str, Any]) -> Options:
    """The Options in keyword arguments. Raises ValueError, a line for each that cannot be meant."""
    data = {name: plain(value) for name, value in given.items()}
    try:
        return Options.model_validate(data)
    except ValidationError as error:
        told = [f"option {sentence(problem, data)}" for problem in schema_problems(error, data, Options)]
        raise ValueError("\n".join(told)) from None


def plain(value: Any) -> Any:
    """Lists and arrays as tuples, numbers of NumPy as Python's, an AutoresetMode as its word."""
    value = value.tolist() if hasattr(value, "tolist") else getattr(value, "value", value)
    return tuples(list(value) if isinstance(value, tuple) else value)
