"""Calls of kernels from Python, again and again with the same types."""

import numba

DIRECT: dict = {}  # kernels that `direct` has called


def direct(function, *arguments):
    """Call a kernel whose arguments are of the same types in every call, as those of a run are.

    From the second call on it is called at once: finding out the types of so many arrays takes longer than handing
    them over.
    """
    call = DIRECT.get(function)
    if call is not None:
        return call(*arguments)
    result = function(*arguments)
    if hasattr(function, "overloads"):  # compilation may be switched off
        DIRECT[function] = function.get_overload(tuple(map(numba.typeof, arguments)))
    return result
