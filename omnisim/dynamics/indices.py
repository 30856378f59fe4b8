"""Which record and which states belong to an axle, a row of rollers, a roller or a contact: all that is counted.

    axle      a wheel w: rows of rollers on one disk, and the contacts that it may have with the floor
    row       rollers that stand along the axle at the `offset` of the row; the rows of an axle take turns
    roller    of an axle in order of azimuth, through all of its rows, counted on through every turn; its index is that
              number modulo N_r, the rollers of the axle
    contact   a side of an axle: on side 0 the roller of the mode, on side 1 its neighbour behind

Tables in Parameters tell where each begins: wheels[w].row and .rows, .rates, .contacts; roller_rows[r]. Kernels that
ask here need not know how many rows an axle has.
"""

import numpy as np

from omnisim.base.kernel import kernel
from omnisim.dynamics.state import BODY_STATES, places


@kernel
def roller_of(mode, side):
    """The roller of a contact, counted on through every turn."""
    return mode.roller - side


@kernel
def contact_count(mode):
    """How many contacts a wheel has: its sides from 0 on."""
    return mode.contacts


@kernel
def roller_index(wheel, roller):
    """Which of the rollers of an axle (0..N_r-1) a roller is that was counted on through every turn."""
    return roller % wheel.rollers


@kernel
def row_index(wheel, roller):
    """On which row a roller of an axle is: where its record ROLLER_ROW stands."""
    return wheel.row + roller % wheel.rows


@kernel
def carries(wheel, mode, side, i):
    """Whether roller i (0..N_r-1) of an axle is that of a contact."""
    return (i - roller_of(mode, side)) % wheel.rollers == 0


@kernel
def sector_of(parameters, w, i, roller):
    """Cosine and sine of the angle from `roller` of an axle to its roller i (0..N_r-1)."""
    found = roller_index(parameters.wheels[w], i - roller)
    return parameters.sector[w, 0, found], parameters.sector[w, 1, found]


@kernel
def rate_place(parameters, mode, w, side):
    """Where the rate of a contact's roller stands in the state."""
    wheel = parameters.wheels[w]
    if parameters.machine.every_rate:
        return np.uint32(wheel.rates + mode.index[side])
    return np.uint32(wheel.rates + side)  # unsigned: nobody tests whether it counts from the end


@kernel
def rho_place(parameters, w, i):
    """Where rho of roller i (0..N_r-1) stands in the state: all rho follow one another, axle by axle."""
    return places(parameters).rho + 3 * (w * parameters.sector.shape[2] + i)


@kernel
def body_place(parameters, w, i):
    """Where the states of a body of axle w begin: i = 0 is its disk, i + 1 its roller i; w = -1: the chassis."""
    each = parameters.sector.shape[2] + 1
    return places(parameters).bodies + (BODY_STATES * (1 + w * each + i) if w >= 0 else 0)
