"""What of a roller touches: the lobes of its generatrix, each a convex body of revolution by itself.

             .--- line ---.                       What is round all over touches a plane with one point. A straight
        lobe/______________\\lobe                  line would touch with all of it at once: so the roller touches with
           `-.          .-'                       what bulges between lines. Lying flat it stands on two lobes.
        - - - -`- - - -'- - - - axis

Beside a line a lobe goes on inside the roller: from BEND of the line's direction with an arc as long as its share of
the line, then with an edge. On a plane that is never the roller's lowest point. Over a kerb, which a line may touch
between its ends, the roller is at most 1.5 BEND of that length thinner than it is.
"""

import math
from itertools import pairwise

from omnisim.scene.generatrix import Arc, Generatrix, edge, mirrored

BEND = 5e-3  # rad
SMALL = 1e-12  # of the roller: what is shorter is rounding

Lobe = list[Arc]  # from tilt 1 to tilt -1, each from where the last one ends


def lobes(arcs: Generatrix) -> list[Lobe]:
    """Of a generatrix, along u."""
    size = max(math.hypot(*arc.at(tilt)) for arc in arcs for tilt in (arc.start, arc.end))
    gaps = [math.dist(a.at(a.end), b.at(b.start)) for a, b in pairwise(arcs)]
    runs: list[list[int]] = []
    for i, arc in enumerate(arcs):
        if arc.bulges and runs and runs[-1][-1] == i - 1 and gaps[i - 1] <= SMALL * size:
            runs[-1].append(i)
        elif arc.bulges:
            runs.append([i])
    # of a line between two lobes each has half
    shares = [gap / (a.bulges + b.bulges or 1) for gap, (a, b) in zip(gaps, pairwise(arcs), strict=True)]
    shares = [0.0, *shares, 0.0]
    return [
        mirrored(closed(mirrored(closed([arcs[i] for i in run], shares[run[0]])), shares[run[-1] + 1])) for run in runs
    ]


def closed(lobe: Lobe, length: float) -> Lobe:
    """A lobe with what it has inside the roller, beside a line before it of this length, m; 0: there is none."""
    first, *rest = lobe
    bend = math.asin(first.start) + BEND
    if length == 0.0 or bend + BEND >= 0.5 * math.pi:
        return [first._replace(start=1.0), *rest]
    tilt, last, radius = math.sin(bend), math.sin(bend + BEND), length / BEND
    u, r = first.at(tilt)
    inner = Arc(u + radius * tilt, r - radius * math.cos(bend), radius, last, tilt)
    return [edge(*inner.at(last), 1.0, last), inner, first._replace(start=tilt), *rest]
