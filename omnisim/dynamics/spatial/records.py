"""What kernels know of a machine free in space, beside what every machine has (parameters.py, state.py).

    y = [ positions: x y z of C, orientation (w, x, y, z), spin_angle of each wheel, s of each carrier | their rates:
          velocity of C, angular velocity along chassis axes, spin_rate of each wheel, s' of each carrier |
          roller rates of each wheel | and what follows them for every machine, among the losses contact_loss,
          damper_loss ]

C: the common centre of mass where every carrier is at s = 0, a point of the chassis. Velocities of C and positions are
in world axes, whose z is the normal of the base plane. Carriers are what wheels stand on that moves in the chassis: the
hub of a suspension slides along z by s, m; a rocker turns about a line by s, rad.

A wheel may touch with several rollers. Their rates have slots in the state, in the order in which they came; what
frozen `modes` know of each contact stands in the same order.
"""

from typing import NamedTuple

import numpy as np

from omnisim.contact.floor import Floor
from omnisim.dynamics.state import TURNING

POSITION, ORIENTATION = 0, 3
SLOTS = 8  # of contacts that a wheel may have at once
CHANGES = 3 * SLOTS  # of contacts, that a wheel may have at one instant
BASE = 0  # of PUSHES: the chassis with what is fixed to it; carrier j follows as j + 1

BODY = np.dtype(
    [
        ("mass", np.float64),  # of everything, kg
        ("mobility", np.float64),  # 1 / mass, 1/kg
        ("base_mass", np.float64),  # of chassis and wheels without a carrier, kg
        ("moment", np.float64, (3,)),  # their first moment about C, kg m; 0 if there is no carrier
        # their inertia about C, and where there is no carrier its inverse; rotors and wheels that follow angles as far
        # as they turn with the chassis
        ("inertia", np.float64, (3, 3)),
        ("turning", np.float64, (3, 3)),  # 1/(kg m^2)
        ("inner_inertia", np.float64, (3, 3)),  # the same without those
        ("gravity", np.float64, (3,)),  # world axes, m/s^2
        ("chassis", np.float64, (3,)),  # where the wrench acts, from C, chassis axes, m
        ("origin", np.float64, (3,)),  # of the chassis from C, chassis axes, m
        ("hull", np.float64, (8, 3)),  # corners of the chassis from C, which must not touch the ground, m
        ("corners", np.int64),  # how many there are
        ("uneven", np.int64),  # 1: the ground is no plane
    ]
)
HUB = np.dtype(
    [
        ("centre", np.float64, (3,)),  # O from C at s = 0, chassis axes, m
        ("h", np.float64, (3,)),  # heading and axle at s = 0, chassis axes
        ("k", np.float64, (3,)),
        ("carrier", np.int64),  # which it stands on, -1: the chassis
        ("stiffness", np.float64),  # of the rubber of its rollers, N/m
        ("damping", np.float64),  # N s/m
        ("coupled", np.float64),  # part of the torque on the axle that turns it: J_k / (J_k + J_r); 0 if it follows
        ("lean", np.float64),  # inertia that turns with the carrier about the axle: J_k J_r / (J_k + J_r), kg m^2
        ("row_count", np.int64),
        ("first_lobe", np.int64),  # of its rollers, among the shapes
        ("lobes", np.int64),
        ("reach", np.float64),  # of a sphere about O that holds its rollers, m
        ("girth", np.float64),  # of a cylinder about the axle that does, m
    ],
    align=True,
)
CARRIER = np.dtype(
    [
        ("turns", np.int64),  # 1: a rocker, 0: a suspension
        ("axis", np.float64, (3,)),  # chassis axes
        ("point", np.float64, (3,)),  # of the line about which it turns, from C, m
        ("stiffness", np.float64),
        ("damping", np.float64),
        ("preload", np.float64),
        ("mass", np.float64),  # with its wheels, kg
        ("centre", np.float64, (3,)),  # of mass, from C at s = 0, m
        ("inertia", np.float64, (3, 3)),  # about that, at s = 0
        ("inner_inertia", np.float64, (3, 3)),  # as of BODY
    ]
)

# What kernels find at an instant.
STAND = np.dtype(  # as of a Standing
    [
        ("h", np.float64, (3,)),
        ("k", np.float64, (3,)),
        ("up", np.float64, (3,)),
        ("centre", np.float64, (3,)),
        ("velocity", np.float64, (3,)),
        ("rate", np.float64, (3,)),
        ("normal", np.float64, (3,)),
        ("cos", np.float64),
        ("sin", np.float64),
        ("spin_rate", np.float64),
        ("stretch", np.float64),
        ("height", np.float64),
        ("clear", np.float64),  # at least as far from the ground was what does not touch it, m, with
        ("clear_contacts", np.int64),
        ("clear_height", np.float64),
        ("clear_normal", np.float64, (3,)),
        ("clear_turn", np.float64, (2,)),  # cosine and sine of the spin angle
        ("clear_lever", np.float64),  # with which what is so near comes down as the wheel spins, m
    ],
    align=True,
)
TOUCH = np.dtype(
    [
        ("depth", np.float64),  # delta, m
        ("normal_force", np.float64),  # N
        ("slip", np.float64, (2,)),  # along h and k in the tangent plane, m/s
        ("force", np.float64, (2,)),  # friction on the roller, N
        *TURNING,
        ("torque", np.float64),  # about the normal, N m
        ("resistance", np.float64, (2,)),  # moment of rolling resistance on the roller along h and k, N m
        ("point", np.float64, (3,)),  # X from O, along h, k and z of the hub, m
        ("normal", np.float64, (3,)),  # of the ground, in the same axes
        ("lever", np.float64, (3,)),  # X - B, in the same axes, m
        ("azimuth", np.float64, (2,)),  # cosine and sine of q
        ("axis", np.float64, (3,)),  # a, in the same axes
        ("stretch", np.float64),  # as of a Touching
        ("tilt", np.float64),
        ("deep", np.float64),
        ("within", np.float64),
        ("press", np.float64),  # as of a Reaction
        ("factor", np.float64),
    ],
    align=True,
)
HELD = np.dtype(
    [
        ("wheel", np.int64),
        ("contact", np.int64),
        ("roller", np.int64),
        ("creeps", np.int64),  # 1: it creeps, 0: it sticks
        ("firm", np.int64),  # along how many of its axes its slip is held
        ("limit", np.float64),  # mu N, N
        ("line", np.float64, (2,)),  # direction of the roller's axis along h and k
        ("leader", np.int64),  # the first contact that lies on one line with it, of its roller
        ("bound", np.int64),  # 1: it creeps, and another one on that line sticks
        ("spin", np.float64, (2,)),  # torque on the axle and on the roller by a unit force along h and k, m
        ("arm", np.float64, (2,)),
        ("bias", np.float64, (2,)),  # slip acceleration without the force of any of them, m/s^2; slip to be taken away
        ("force", np.float64, (2,)),  # N; N s of an impulse
        ("begun", np.float64, (2,)),  # direction of creeping slip as the mode has it, and the rate at which it turns:
        ("veer", np.float64, (2,)),  # rad/s, and 1/s by the angle from there
        ("slip", np.float64, (2,)),  # along h and k, m/s
        ("turned", np.float64),  # by the last correction of that direction, rad
        ("yields", np.float64, (3,)),  # slip acceleration hh, hk, kk by its force while those that stick hold, 1/kg
    ],
    align=True,
)
MOTION = np.dtype(
    [
        ("cos", np.float64),  # of the angle by which a rocker is turned
        ("sin", np.float64),
        ("centre", np.float64, (3,)),  # of its mass from C, m
        ("inertia", np.float64, (3, 3)),  # about that, chassis axes
        ("inner_inertia", np.float64, (3, 3)),
        ("turning", np.float64, (3,)),  # its screw: turning, and velocity of what is at C
        ("at_origin", np.float64, (3,)),
    ]
)
SPATIAL_MODE = np.dtype(
    [
        ("rollers", np.int64),  # how many touch
        ("roller", np.int64, (SLOTS,)),  # which, 0..N-1
        ("contacts", np.int64),  # how many contacts they have: one each, but on a step
        ("slot", np.int64, (SLOTS,)),  # of each contact: which of the rollers that touch
        ("first", np.int64, (SLOTS,)),  # 1: it is the first of its roller
        ("meeting", np.int64, (SLOTS,)),  # which lobe meets which piece of the floor, see touching.py
        ("region", np.int64, (SLOTS,)),  # of the roller, see support.py
        ("pressed", np.int64, (SLOTS,)),  # 1: the rubber presses, N > 0
        ("saturated", np.int64, (SLOTS,)),  # branch of the saturated friction law
        ("grip", np.int64, (SLOTS,)),  # as of MODE
        ("creep", np.float64, (SLOTS, 2)),
        ("veer", np.float64, (SLOTS, 2)),
        ("veering", np.float64, (SLOTS,)),
        ("foreseen", np.int64, (SLOTS,)),
        ("period", np.float64, (SLOTS,)),
        ("pull", np.float64, (SLOTS,)),
        ("settled", np.float64, (SLOTS,)),
        ("strayed", np.float64, (SLOTS,)),
        ("stopping", np.int64, (SLOTS,)),
        ("stopped", np.int64, (SLOTS,)),
        ("freed", np.int64),
        ("freed_step", np.int64),
        ("shared", np.int64),  # 0: rubber shares the load
        ("drive", np.int64),  # as of MODE
        ("held", np.float64),
        ("integral", np.float64),
        ("winding", np.float64),
        ("read_rate", np.float64),
        ("past_rate", np.float64),
        ("air_cos", np.float64),  # sums over the rollers in the air, gamma_i their angles on the disk:
        ("air_sin", np.float64),  # sum p_i cos gamma_i, sum p_i sin gamma_i and sum p_i, rad/s
        ("air_sum", np.float64),
    ]
)
SPATIAL_MONITORS = np.dtype(
    [
        ("normal_force", np.float64),  # of the whole wheel, N
        ("demand", np.float64),  # of the drive
        ("gap", np.float64),  # between the ground and the next roller to touch it, m
        ("depth", np.float64, (SLOTS,)),
        ("load", np.float64, (SLOTS,)),  # N
        ("press", np.float64, (SLOTS,)),
        ("inside", np.float64, (SLOTS,)),  # its region
        ("within", np.float64, (SLOTS,)),  # its piece of the floor, m
        ("slip_square", np.float64, (SLOTS,)),
        ("factor", np.float64, (SLOTS,)),
        ("relaxing", np.float64, (SLOTS,)),
        ("margin", np.float64, (SLOTS,)),  # as of MONITORS
    ]
)


class Holding(NamedTuple):
    """Workspace for contacts at rest, at most M: contacts (M,): records HELD; felt (M, 2, 6 + C): what a unit force
    along h and k does to chassis and carriers, given (M, 2, 6 + C): how these are accelerated by it; mobility
    (2 M, 2 M), 1/kg, system (2 M, 2 M) and side (2 M,): equations."""

    contacts: np.recarray
    felt: np.ndarray
    given: np.ndarray
    mobility: np.ndarray
    system: np.ndarray
    side: np.ndarray


class Space(NamedTuple):
    """A machine free in space: W wheels of at most N rollers, C carriers.

    body: record BODY. hubs (W,): records HUB. shapes (L,): records SHAPE of the lobes of their rollers, wheel after
    wheel. disk (W, 3, N): cosine and sine of the angle of each roller on its disk, and its offset along the axle, m.
    floor: Floor, a plane one without any part. carriers (C,): records CARRIER.

    Then what is found at an instant: stands (W,): records STAND; touches (W * SLOTS,): records TOUCH; motions (C,):
    records MOTION; pushes (1 + C, 6): moment about C and force on chassis and carriers, chassis axes; balance
    (6 + C, 6 + C) and answer (6 + C,): their equations; shifted (n,): a state nearby; bent (n,): the bend of the
    extension of a step, last (n,): the state where the one before it began (march/spatial_location.py). changes (M, 3):
    Guards that have fired together, up to one of kind -1. holding: Holding, None with a smooth law.
    """

    body: np.record
    hubs: np.recarray
    shapes: np.recarray
    disk: np.ndarray
    floor: Floor
    carriers: np.recarray
    stands: np.recarray
    touches: np.recarray
    motions: np.recarray
    pushes: np.ndarray
    balance: np.ndarray
    answer: np.ndarray
    shifted: np.ndarray
    bent: np.ndarray
    last: np.ndarray
    changes: np.ndarray
    holding: Holding | None
