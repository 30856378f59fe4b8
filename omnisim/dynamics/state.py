"""The records of a march by lifetime: the state vector, the mode that is frozen within a step, the clock, the rows.

    y = [ positions: x y yaw, spin_angle of each wheel | their rates, in the same order |
          roller rates of each wheel | integrated rate error of each wheel's drive | current of each motor |
          friction_loss drive_work wrench_work, with bearing friction bearing_loss, with
          rolling resistance rolling_loss,
          with motors electrical heat motor_loss motor_work | x y of the wheels' odometry |
          rho of every roller (implicit tracking) | r Q v w of every body, drift (formulation "multibody") ]

x, y: of the common centre of mass C. Drive integrals, currents, energies of motors, bearing loss and odometry are there
only if the scene has them.

Roller rates are absolute axial rates p. A roller in the air keeps its own exactly, so only those of the rollers in
contact are states: two slots for each wheel, the second in use while two rollers carry it; the others stand in
`rates`. With bearing friction, and where rollers are bodies, every roller has its slot. The works are integrated with
the motion. Bodies are held where these joint coordinates put them, at the end of every step; the drift is the largest
distance (m or rad; m/s or rad/s) by which a step has taken a body from there so far.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel

X, Y, YAW = range(3)
TOUCHING = 2  # contacts that a wheel may have with a flat floor: one roller, or on their common edge two
BODY_STATES = 13  # of each rigid body: see rigid_body.py


class Places(NamedTuple):
    """Where each part of the state begins; of quantities that every wheel has, wheel w's stands w places further."""

    spin_angle: int
    velocity: int  # x, then y
    yaw_rate: int
    spin_rate: int
    roller_rate: int  # wheel w's slots begin w * slots further
    integral: int
    current: int
    friction_loss: int
    drive_work: int
    wrench_work: int
    bearing_loss: int
    electrical: int  # energy from the supply of all motors; then their heat, friction, and work at the wheels
    heat: int
    motor_loss: int
    motor_work: int
    odometry: int
    rho: int
    bodies: int
    drift: int  # of positions, then of velocities
    rate: int = 0  # of a machine free in space: its angular velocity; then what its carriers have, and its own losses
    joint: int = 0
    joint_rate: int = 0
    contact_loss: int = 0
    damper_loss: int = 0
    rolling_loss: int = 0


# No index made of unsigned numbers can count from the end, so compiled code need not ask.
PLACES = np.dtype([(name, np.uint32) for name in Places._fields])


@kernel
def places(parameters):
    """The Places of the state of a machine, a record PLACES."""
    return parameters.machine.places


def places_in(parameters):
    """The same outside kernels: Places."""
    machine = parameters.machine
    if isinstance(machine, np.void):  # all of a record at once: what nests in it takes longer to read
        return Places(*machine.item()[machine.dtype.names.index("places")])
    return Places(*machine.places)


class Contents(NamedTuple):
    """What a state holds: how many wheels, slots of roller rates for each, rollers with a rho, and bodies; of the
    others 1 if the scene has them."""

    wheels: int
    slots: int = 2
    integrals: int = 0
    currents: int = 0
    bearing_friction: int = 0
    motors: int = 0
    odometry: int = 0
    rhos: int = 0
    bodies: int = 0
    carriers: int = 0
    rolling: int = 0


@lru_cache
def places_of(contents):
    """The Places of a state with such Contents."""
    wheels, slots, integrals, currents, bearing_friction, motors, odometry, rhos, bodies, _, rolling = contents
    rates = 3 + wheels
    rollers = 6 + 2 * wheels
    integral = 6 + 2 * wheels + slots * wheels
    current = integral + integrals * wheels
    works = current + currents * wheels
    energies = works + 3 + bearing_friction + rolling
    pose = energies + 4 * motors
    rho = pose + 2 * odometry
    first = rho + 3 * rhos
    drift = first + BODY_STATES * bodies
    works, energies = range(works, works + 4), range(energies, energies + 4)
    drives = integral, current, *works, *energies
    found = Places(3, rates, rates + 2, rates + 3, rollers, *drives, pose, rho, first, drift)
    return found._replace(rolling_loss=found.bearing_loss + bearing_friction)


@lru_cache
def places_in_space(contents):
    """The same of a machine free in space, whose state spatial/records.py describes."""
    wheels, slots, integrals, currents, bearing_friction, motors, odometry, _, _, carriers, rolling = contents
    joint = 7 + wheels
    velocity = joint + carriers
    spin_rate = velocity + 6
    joint_rate = spin_rate + wheels
    rollers = joint_rate + carriers
    integral = rollers + slots * wheels
    current = integral + integrals * wheels
    works = current + currents * wheels
    losses = works + 3 + bearing_friction + rolling
    energies = losses + 2
    pose = energies + 4 * motors
    end = pose + 2 * odometry
    drives = integral, current, *range(works, works + 4), *range(energies, energies + 4)
    own = velocity + 3, joint, joint_rate, losses, losses + 1, losses - rolling
    return Places(7, velocity, velocity + 5, spin_rate, rollers, *drives, pose, end, end, end, *own)


NODES = 8  # of the stages of an explicit step, at most
# How the direction of creeping slip turns at a contact in a step: march/creeping.py.
TURNING = [
    ("creep", np.float64, (2,)),  # direction of creeping slip
    ("nodes", np.int64),  # of the stages of the step so far, and
    ("node", np.float64, (NODES,)),  # the part of the step at each, 1
    ("angle", np.float64, (NODES,)),  # of the direction there from that at the start, rad, and
    ("difference", np.float64, (NODES,)),  # divided differences of these, rad
    ("missed", np.float64),  # by which the last of them is off the polynomial through those before it, rad
    ("veering", np.float64),  # rate at which it turns at the end of a step, rad/s
]
MODE = np.dtype(
    [
        ("roller", np.int64),  # of contact 0, counted on through every turn of its axle: see indices.py
        ("index", np.uint32, (TOUCHING,)),  # of the roller at each contact, 0..N_r-1
        ("row", np.uint32, (TOUCHING,)),  # on which row of rollers each contact is, never counted from the end
        ("direction", np.int64),  # +1 or -1: sense in which the spin angle runs throughout a step
        ("contacts", np.int64),  # how many it has: 1, or 2 while
        ("shared", np.int64),  # 1: the wheel rests on `roller` at q = +alpha and on the one behind it, contact 1
        ("loaded", np.int64),  # 1: the floor carries the wheel
        ("drive", np.int64),  # actuation.BY_LIMIT or BY_CURRENT by its sense: the limit it is at; FREE: at none
        ("held", np.float64),  # demand of a sampled controller since its last sample, V
        ("integral", np.float64),  # of its error until then, rad
        ("winding", np.float64),  # what one sample adds to that by its time, rad/s
        ("read_rate", np.float64),  # spin rate that it read then, rad/s
        ("past_rate", np.float64),  # and one sample before
        ("saturated", np.int64, (TOUCHING,)),  # branch of the saturated friction law at each contact
        ("grip", np.int64, (TOUCHING,)),  # coulomb.SLIP, STICK or CREEP
        ("creep", np.float64, (TOUCHING, 2)),  # direction of creeping slip at the last step; 0: not known yet
        ("veer", np.float64, (TOUCHING, 2)),  # rate at which it turns: rad/s, and 1/s by the angle from `creep`
        ("veering", np.float64, (TOUCHING,)),  # rate at which it turned at the end of the last step, rad/s
        ("foreseen", np.int64, (TOUCHING,)),  # 1: it does so still, as no force has jumped since
        ("period", np.float64, (TOUCHING,)),  # how long it may creep at once, s: creeping_period
        ("pull", np.float64, (TOUCHING,)),  # rate at which friction turns slip as the contact equation says, 1/s
        ("settled", np.float64, (TOUCHING,)),  # how often it has done so since forces have jumped, 1
        ("strayed", np.float64, (TOUCHING,)),  # angle of slip from that direction, at most, rad
        ("seen", np.float64, (4,)),  # of slow slip at contact 0: b, mu N tr A (m/s^2) and when, s; < 0: not yet
        ("layer", np.float64, (2,)),  # slip of a sticking contact 0 within slip_layer, m/s,
        ("easing", np.float64, (2,)),  # its rate, m/s^2, as seen since
        ("eased", np.float64, (2,)),  # it was this, m/s,
        ("since", np.float64),  # so long ago, s; < 0: it has none
        ("stopping", np.int64, (TOUCHING,)),  # 1: it had a direction of its own; 0: it was released
        ("stopped", np.int64, (TOUCHING,)),  # 1: slip has just come to its end at this contact
        ("freed", np.int64),  # how often creeping slip got a direction of its own in the grid step
        ("freed_step", np.int64),  # where it last did so
        ("air_cos", np.float64),  # sums over the rollers in the air, D_i = gamma_i - gamma_contact:
        ("air_sin", np.float64),  # sum p_i cos D_i, sum p_i sin D_i and sum p_i, rad/s
        ("air_sum", np.float64),
    ]
)
MONITORS = np.dtype(
    [
        ("normal_force", np.float64),  # of the whole wheel, N; below 0 of one that the floor does not carry
        ("demand", np.float64),  # of the drive: torque (N m) or voltage (V) without its limits
        ("regular", np.float64),  # determinant of the loads over that without friction, 1
        ("share", np.float64),  # of contact 0 in it, 1
        ("share_margin", np.float64),  # torque with which both contacts alone would push back to the edge, N m
        ("slip_square", np.float64, (TOUCHING,)),  # |v|^2 at each contact, m^2/s^2
        # coulomb: mu N - |F| while sticking, v . u while creeping; 0 on two rollers
        ("margin", np.float64, (TOUCHING,)),
        ("factor", np.float64, (TOUCHING,)),  # g of the friction law F = -g v, N s/m
        ("relaxing", np.float64, (TOUCHING,)),  # rate at which rolling resistance stops a roller, at most, 1/s
    ]
)
EXTREME = np.dtype(
    [
        ("normal_force", np.float64, (2,)),  # of the whole wheel, least and most, N
        ("drive_torque", np.float64, (2,)),  # N m
        ("drive_power", np.float64, (2,)),  # W
        ("voltage", np.float64, (2,)),  # of a motor, V
        ("current", np.float64, (2,)),  # A
        ("electrical_power", np.float64, (2,)),  # W
        ("friction_square", np.float64),  # |F|^2 at any of its contacts, most, N^2
        ("slip_square", np.float64),  # |v|^2, m^2/s^2
    ]
)
CLOCK = np.dtype(
    [
        ("steps", np.int64),  # grid steps in all
        ("steps_per_row", np.int64),
        ("goal", np.int64),  # grid steps up to which the march goes
        ("step", np.int64),  # grid steps done
        ("row", np.int64),  # output rows written
        ("piece", np.uint32),  # of the tables
        ("events", np.int64),  # in the log
        ("rhs", np.int64),  # right-hand sides evaluated
        ("pause", np.int64),  # number of them at which the march returns to its caller
        ("stiff", np.int64),  # surplus of steps too large for the rate at which slip relaxes
        ("choice", np.int64),  # tableau.EXPLICIT, IMPLICIT or AUTO
        ("implicit", np.int64),  # the step under way is implicit
        ("converged", np.int64),  # the last trial step: an implicit one may fail
        ("energy", np.float64),  # kinetic, at the start, J
        ("potential", np.float64),  # of the weight on an inclined floor, at the start, J
        ("turnover", np.float64),  # the largest sum of that and of the works so far, J
        ("status", np.int64),
        ("wheel", np.int64),  # that caused the status, or -1
        ("dt", np.float64),  # s
        ("fineness", np.float64),  # of sub-steps of slip: march/substeps.py
        ("aligned", np.float64),  # slip across its final direction that does not matter, m/s: march/slip_bounds.py
        ("stopping", np.float64),  # twice the same along slip about to stop, m/s
        ("ended", np.float64),  # change of a speed by what changes in the last of slip, that does not matter, m/s
        ("lasted", np.float64),  # how long slip has lasted that is about to end by last_slip.py, else 0, s
        ("elapsed", np.float64),  # in the grid step under way, s
        ("late", np.float64),  # by which that has gone on beyond the event that is to be made, s
        ("smooth", np.float64),  # length of the last step, if nothing has jumped or bent since it began, else 0, s
        ("reach", np.float64),  # length of the last implicit step that converged, s
        ("rate", np.float64),  # relaxation rate of slip when found too stiff, 1/s
        ("stability_limit", np.float64),  # of the method on the negative real axis, 1
    ],
    align=True,
)


class Stage(NamedTuple):
    """One evaluation of the right-hand side, n states, W wheels.

    mode (W,): records MODE; piece of the tables and time t, s; y (n,): the state; dy (n,): where its rates go; monitors
    (W,): records MONITORS, written only if `monitoring`, as is what else only events and observers want to know.
    """

    mode: np.ndarray
    piece: int
    t: float
    y: np.ndarray
    dy: np.ndarray
    monitors: np.recarray
    monitoring: bool


class Newton(NamedTuple):
    """Workspace for the iteration of implicit steps on k coupled of n states.

    active (k,): those states, ascending; busy (k,): at first those of them that are not idle; stages (9, n): increments
    z and derivatives of the three stages, a derivative and two states beside the state; real (2 k + 1, k) float,
    complex (k + 1, k): Jacobian, factors and right side; pivots (2, k) of the real and the complex factors; sought
    (W,): whether the slip of a wheel is an unknown, in the place of its own rates.
    """

    active: np.ndarray
    busy: np.ndarray
    stages: np.ndarray
    real: np.ndarray
    complex: np.ndarray
    pivots: np.ndarray
    sought: np.ndarray


class Run(NamedTuple):
    """The mutable part of a march, n states, W wheels, N rollers, s stages.

    y, trial, carry, increment (n,), the last two of compensated summation; slopes (s + 1, n): stage
    derivatives, the first at the start of the step and the last at its end; rates (W, N): absolute axial rate of every
    roller, rad/s (of the one in contact as of its last exchange); mode (W,): records MODE; monitors, monitors_end (W,):
    records MONITORS at the start and end of the step; clock: record CLOCK; newton: Newton, None if all steps are
    explicit.
    """

    y: np.ndarray
    trial: np.ndarray
    carry: np.ndarray
    increment: np.ndarray
    slopes: np.ndarray
    rates: np.ndarray
    mode: np.recarray
    monitors: np.recarray
    monitors_end: np.recarray
    clock: np.record
    newton: Newton | None


class Recording(NamedTuple):
    """What is recorded at the T output times, and of the interval that each of them ends; the next one is under way.

    y (T, n): states; rates (T, W, N); mode (T, W); piece (T,); extremes (T, W): records EXTREME. bearing_extremes
    (T, W, 4, N + 1): of axle and rollers as extremes.py counts them, odometry_extremes (T, 3): of the error of the
    reported pose; no rows where a scene has none.
    """

    y: np.ndarray
    rates: np.ndarray
    mode: np.ndarray
    piece: np.ndarray
    extremes: np.ndarray
    bearing_extremes: np.ndarray
    odometry_extremes: np.ndarray
