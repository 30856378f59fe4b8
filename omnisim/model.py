"""What of the physics a scene asks for, and what is left out, each with its reason."""

from typing import NamedTuple

from omnisim.config import Config


class Model(NamedTuple):
    line: str


def describe(config: Config) -> Model:
    return Model("todo")
