"""What follows from things that never change, kept: machines that differ in a few numbers have all else in common."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

MOST = 64  # things of which a function knows what follows
Function = TypeVar("Function", bound=Callable[..., Any])


def kept(function: Function, by: int | None = None) -> Function:
    """The function, which finds what follows from its arguments once, as long as they are the very same objects.

    For arguments that never change, frozen tables and tuples of numbers, and results that nobody writes into. Whether
    two are equal is not asked: that would take long, and 0.0 equals -0.0. What is known holds its arguments, so that no
    other object can take their place in memory; when it is too much, all of it is forgotten. by: how many of the
    arguments tell the rest of them; all of them without it.
    """
    known: dict[tuple[int, ...], tuple[tuple[Any, ...], Any]] = {}

    @wraps(function)
    def found(*arguments: Any) -> Any:
        telling = arguments[:by]
        key = tuple(map(id, telling))
        entry = known.get(key)
        if entry is None:
            if len(known) >= MOST:
                known.clear()
            entry = known[key] = telling, function(*arguments)
        return entry[1]

    return cast(Function, found)


def kept_by_first(function: Function) -> Function:
    """The same of a function whose first argument tells the rest of them."""
    return kept(function, 1)
