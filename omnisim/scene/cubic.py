"""The cubic through a table: continuous to the second derivative, which is linear between the points.

    h_i-1 m_i-1 + 2 (h_i-1 + h_i) m_i + h_i m_i+1 = 6 (d_i - d_i-1)      h steps of time, d slopes of the chords

with a given slope s at the start, 2 h_0 m_0 + h_0 m_1 = 6 (d_0 - s), and m = 0 at the end (de Boor, A Practical Guide
to Splines, 1978, chapter IV).
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise


@lru_cache(maxsize=16)
def cubic_curvature(times: Sequence[float], values: Sequence[float], slope: float) -> tuple[float, ...]:
    """m: the second derivative at each of two times or more, ascending; slope: at the first of them."""
    steps = [after - before for before, after in pairwise(times)]
    chords = [(after - before) / step for (before, after), step in zip(pairwise(values), steps, strict=True)]
    # Elimination forward: m_i = right_i - above_i m_i+1
    above, right = [0.5], [3.0 * (chords[0] - slope) / steps[0]]
    for (before, after), (low, high) in zip(pairwise(steps), pairwise(chords), strict=True):
        pivot = 2.0 * (before + after) - before * above[-1]
        above.append(after / pivot)
        right.append((6.0 * (high - low) - before * right[-1]) / pivot)
    curvature = [0.0]
    for factor, own in zip(reversed(above), reversed(right), strict=True):
        curvature.append(own - factor * curvature[-1])
    return tuple(reversed(curvature))
