"""Calls of kernels from Python: again and again with the same types, or with NumPy in the place of the compiler."""

import numba

DIRECT: dict = {}  # kernels that `direct` has called, by what their arguments have


def direct(function, *arguments):
    """Call a kernel whose arguments are of the same types in every call but for members that are there or None; the
    order of an array in memory is part of its type, and is not looked at.

    From the second call on it is called at once: finding out the types of so many arrays takes longer than handing
    them over.
    """
    call = at_once(function, arguments)
    if call is not None:
        return call(*arguments)
    result = function(*arguments)
    if hasattr(function, "entry"):  # compilation may be switched off
        DIRECT[key_of(function, arguments)] = function.entry.get_overload(tuple(map(numba.typeof, arguments)))
    return result


def at_once(function, arguments):
    """What `direct` calls at once, for such arguments; None until it has called the function."""
    return DIRECT.get(key_of(function, arguments))


def key_of(function, arguments):
    return function, *[members(argument) for argument in arguments if isinstance(argument, tuple)]


def members(argument):
    """The Python types of the members of a NamedTuple, then those of theirs."""
    return *map(type, argument), *[members(member) for member in argument if isinstance(member, tuple)]


def by_columns(function, *arguments):
    """A kernel as the Python function that it is: arrays go through its arithmetic as numbers do, a column a state."""
    return getattr(function, "py_func", function)(*arguments)
