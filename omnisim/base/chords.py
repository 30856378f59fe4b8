"""Roots by chords (regula falsi) between two ends with values of both signs."""

from omnisim.base.kernel import kernel


@kernel
def staying(found, before):
    """Factor on the value at the end that stays for a second time, while that at the other end goes from `before` to
    `found`, of one sign (Anderson & Björck 1973): the next chord bends as the function does. Of order 1.7, where a
    half each time, the Illinois variant, is of 1.44."""
    factor = 1.0 - found / before
    return factor if factor > 0.0 else 0.5
