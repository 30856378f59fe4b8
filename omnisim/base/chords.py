"""Roots by chords (regula falsi) between two ends with values of both signs."""

from omnisim.base.kernel import kernel

FLAT = 0.1  # part by which a value changes at least, for a chord that bends
FOUND = 1e-12  # of what is searched: as far as a root may be missed
NEARLY = 1e-9  # the same, from which on a root may be told by how chords have settled


@kernel
def staying(found, before):
    """Factor on the value at the end that stays for a second time, while that at the other end goes from `before` to
    `found`, of one sign (Anderson & Björck 1973): the next chord bends as the function does. Of order 1.7, where a
    half each time, the Illinois variant, is of 1.44. Where the function is flat at the end that moves it is a half:
    less would take the chord all the way back."""
    factor = 1.0 - found / before
    return factor if factor > FLAT else 0.5


@kernel
def settled(moved, before):
    """Whether a root is found that a chord has moved by `moved`, and the one before it by `before` (0: there was none):
    if the next one moves it by the same part of that again, it moves it by no more than FOUND. Values carry rounding,
    and to look at them once more would tell nothing else."""
    return moved <= FOUND or (moved <= NEARLY and moved * moved <= FOUND * before)
