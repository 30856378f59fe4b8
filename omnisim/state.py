"""The records of a march by lifetime: the state vector, the mode that is frozen within a step, the clock, the rows.

    y = [ positions: x y yaw, spin_angle of each wheel | their rates, in the same order |
          roller_rate of each wheel | friction_loss drive_work wrench_work | rho of every roller (implicit tracking) ]

`roller_rate` is the absolute axial rate p of the roller in contact; the rollers in the air keep theirs exactly and
stand in `rates`, outside the state. The works are integrated with the motion by the same tableau.
"""

from typing import NamedTuple

import numpy as np

from omnisim.kernel import kernel

X, Y, YAW = range(3)


class Places(NamedTuple):
    """Where each part of the state begins; of quantities that every wheel has, wheel w's stands w places further."""

    spin_angle: int
    velocity: int  # x, then y
    yaw_rate: int
    spin_rate: int
    roller_rate: int
    friction_loss: int
    drive_work: int
    wrench_work: int
    rho: int


@kernel
def places(wheels):
    """The Places of the state of a machine with so many wheels."""
    rates, rollers, works = 3 + wheels, 6 + 2 * wheels, 6 + 3 * wheels
    return Places(3, rates, rates + 2, rates + 3, rollers, works, works + 1, works + 2, works + 3)


MODE = np.dtype(
    [
        ("roller", np.int64),  # of the contact, counted on through every turn: its index is roller mod N_r
        ("direction", np.int64),  # +1 or -1: sense in which the spin angle runs throughout a step
        ("saturated", np.int64),  # branch of the saturated friction law
        ("grip", np.int64),  # coulomb.SLIP, STICK or CREEP
        ("air_cos", np.float64),  # sums over the rollers in the air, D_i = gamma_i - gamma_contact:
        ("air_sin", np.float64),  # sum p_i cos D_i, sum p_i sin D_i and sum p_i, rad/s
        ("air_sum", np.float64),
    ]
)
WATCH = np.dtype(
    [
        ("normal_force", np.float64),  # N
        ("slip_square", np.float64),  # |v|^2, m^2/s^2
        ("margin", np.float64),  # coulomb: mu N - |F| while sticking, v . u while creeping
        ("factor", np.float64),  # g of the friction law F = -g v, N s/m
    ]
)
CLOCK = np.dtype(
    [
        ("steps", np.int64),  # grid steps in all
        ("steps_per_row", np.int64),
        ("step", np.int64),  # grid steps done
        ("row", np.int64),  # output rows written
        ("piece", np.int64),  # of the tables
        ("events", np.int64),  # in the log
        ("rhs", np.int64),  # right-hand sides evaluated
        ("pause", np.int64),  # number of them at which the march returns to its caller
        ("stiff", np.int64),  # surplus of steps too large for the rate at which slip relaxes
        ("choice", np.int64),  # tableau.EXPLICIT, IMPLICIT or AUTO
        ("implicit", np.int64),  # the step under way is implicit
        ("converged", np.int64),  # the last trial step: an implicit one may fail
        ("implicit_steps", np.int64),  # taken, parts of steps counted each
        ("status", np.int64),
        ("wheel", np.int64),  # that caused the status, or -1
        ("dt", np.float64),  # s
        ("elapsed", np.float64),  # in the grid step under way, s
        ("reach", np.float64),  # length of the last implicit step that converged, s
        ("rate", np.float64),  # relaxation rate of slip when found too stiff, 1/s
        ("stability_limit", np.float64),  # of the method on the negative real axis, 1
    ]
)


class Newton(NamedTuple):
    """Room for the iteration of implicit steps on k coupled of n states; k = n = 0 when the method is explicit.

    active (k,): those states, ascending; z, slopes (3, n): increments and derivatives of the stages; shifted (n,);
    jacobian, real, complex (k, k): of the active slopes, and factors; pivots and right sides (k,).
    """

    active: np.ndarray
    z: np.ndarray
    slopes: np.ndarray
    shifted: np.ndarray
    jacobian: np.ndarray
    real: np.ndarray
    complex: np.ndarray
    real_pivots: np.ndarray
    complex_pivots: np.ndarray
    real_side: np.ndarray
    complex_side: np.ndarray


class Run(NamedTuple):
    """The mutable part of a march, n states, W wheels, N rollers, s stages.

    y, trial, stage, carry, increment (n,), the last two of compensated summation; slopes (s + 1, n): stage
    derivatives, the first at the start of the step and the last at its end; rates (W, N): absolute axial rate of every
    roller, rad/s (of the one in contact as of its last exchange); mode (W,): records MODE; watch, watch_end (W,):
    records WATCH at the start and end of the step; clock: record CLOCK; newton: Newton.
    """

    y: np.ndarray
    trial: np.ndarray
    stage: np.ndarray
    carry: np.ndarray
    increment: np.ndarray
    slopes: np.ndarray
    rates: np.ndarray
    mode: np.recarray
    watch: np.recarray
    watch_end: np.recarray
    clock: np.record
    newton: Newton


class Rows(NamedTuple):
    """What is recorded at the T output times: states (T, n), rates (T, W, N), mode (T, W) and piece (T,)."""

    y: np.ndarray
    rates: np.ndarray
    mode: np.recarray
    piece: np.ndarray
