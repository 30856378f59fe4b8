"""What follows from things that never change, kept: machines that differ in a few numbers have all else in common."""

import pickle
from collections.abc import Callable
from functools import wraps
from typing import Any, Generic, Protocol, TypeVar, cast

MOST = 64  # things of which a function knows what follows
Function = TypeVar("Function", bound=Callable[..., Any])
Variant = TypeVar("Variant")
Found = TypeVar("Found")


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


class Unknown:
    """Stands for a value that is not known yet. It may be handed on; whoever looks at it raises TypeError."""

    def _looked_at(self, *_: Any) -> Any:
        raise TypeError("nobody knows this value yet")

    __eq__ = __ne__ = __hash__ = __bool__ = __repr__ = __format__ = __reduce_ex__ = _looked_at
    __class__ = property(_looked_at)  # isinstance asks for it


UNKNOWN = Unknown()


class Ask(Protocol[Variant]):
    """Who finds what a function makes of something."""

    def __call__(self, function: Callable[[Variant], Found], variant: Variant, /) -> Found: ...


def alone(function: Callable[[Variant], Found], variant: Variant) -> Found:
    """Asks the function itself."""
    return function(variant)


class Common(Generic[Variant]):
    """What variants of something have in common.

    sample: one of them, with UNKNOWN in the place of all values in which they may differ. What a function makes of it
    without a look at those, it makes of every variant: that is found once, and nobody may write into it. All else is
    found for each variant by itself.
    """

    def __init__(self, sample: Variant):
        self.sample = sample
        self._found: dict[Callable[[Variant], Any], tuple[Any, ...]] = {}

    def __call__(self, function: Callable[[Variant], Found], variant: Variant) -> Found:
        found = self._found.get(function)
        if found is None:
            found = self._found[function] = self._without_a_look(function)
        return found[0] if found else function(variant)

    def _without_a_look(self, function: Callable[[Variant], Found]) -> tuple[Found, ...]:
        """What the function makes of the sample, if it can."""
        try:
            found = function(self.sample)
            pickle.dumps(found)  # which looks at everything in it
        except Exception:  # whatever a function makes of a look that it may not take
            return ()
        return (found,)
