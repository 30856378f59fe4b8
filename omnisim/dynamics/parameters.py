"""What the kernels know of a scene and never changes, as records and arrays; packing.py makes them."""

from typing import NamedTuple

import numpy as np

from omnisim.base.records import without
from omnisim.dynamics.spatial.records import Space
from omnisim.dynamics.state import PLACES, TOUCHING, TURNING

MACHINE = np.dtype(
    [
        ("gravity", np.float64),  # towards the floor, m/s^2
        ("downhill", np.float64, (2,)),  # gravity along the floor: world x and y, m/s^2
        ("inclined", np.int64),  # 1: there is some
        ("mass", np.float64),  # M: everything, kg
        ("yaw_inertia", np.float64),  # I_z, kg m^2
        ("height", np.float64),  # z_C: of the common centre of mass C, m
        ("moment", np.float64, (2,)),  # S = sum m z e, chassis axes, kg m^2
        ("centre", np.float64, (2,)),  # C from the chassis origin, chassis axes, m
        ("lever", np.float64, (3,)),  # r: from C to where the wrench acts, chassis axes, m
        ("upright", np.int64),  # SERVO or CONTACTS: what carries roll and pitch
        ("law", np.int64),  # friction.LAWS
        ("viscous", np.int64),  # 1: it is that which knows no load
        ("brush", np.int64),  # 1: it is that of rubber that creeps
        ("friction", np.float64),  # mu, 1
        ("slip_speed", np.float64),  # m/s
        ("slip_layer", np.float64),  # slip at which a sticking contact gives mu N, m/s; 0: it does not slip
        ("creep_stiffness", np.float64),  # c: force by load, by ratio of slip, 1
        ("viscosity", np.float64),  # N s/m
        ("slip_floor", np.float64),  # slip over which friction changes near zero slip, m/s
        ("patch_radius", np.float64),  # of the contact patch, m; 0: no contact torque
        ("implicit_tracking", np.int64),  # 1: contacts are found from the rho of rollers, which are states
        ("chassis_mass", np.float64),  # kg; 0 of a bare wheel
        ("chassis_inertia", np.float64, (3,)),  # about its own axes, kg m^2
        ("bearing_friction", np.int64),  # 1: bearing friction
        ("rolling", np.int64),  # 1: rolling resistance
        ("every_rate", np.int64),  # 1: the rates of all rollers are states
        ("bearing_relaxation", np.float64),  # fastest rate at which bearing friction stops a roller, 1/s
        ("slots", np.int64),  # of roller rates in the state, for each wheel
        ("integrals", np.int64),  # 1: drives integrate the error of their rate, a state for each wheel
        ("motors", np.int64),  # 1: there are motors, whose energies are states
        ("currents", np.int64),  # 1: some have an inductance: a current for each wheel
        ("current_relaxation", np.float64),  # fastest rate at which a current settles, R_a / L, 1/s
        ("follows", np.int64),  # 1: some drives turn their wheels as tables of angles say
        ("sampled", np.int64),  # 1: some controllers read their rates at samples
        ("odometry", np.int64),  # 1: the ideal kinematics of the wheels tell a pose
        ("odometry_yaw", np.float64),  # of that pose at spin angles 0, rad
        ("pushed", np.int64),  # 1: there is an external wrench
        ("body_frame", np.int64),  # 1: the wrench turns with the yaw
        ("slip_mobility", np.float64),  # upper bound of the contact's inverse mass, 1/kg
        ("mobility", np.float64),  # 1 / M, 1/kg
        ("yaw_mobility", np.float64),  # 1 / I_z, 1/(kg m^2)
        ("places", PLACES),  # of the state
    ]
)
# What few machines have. Where one has none of it all of these are 0, and its record is PLAIN: steps take a tenth less.
# Every kind of record is compiled for once more, so that these make one kind, not one each.
SELDOM = (
    *("viscous", "brush", "patch_radius", "implicit_tracking"),
    *("bearing_friction", "rolling", "every_rate", "bearing_relaxation"),
    *("motors", "currents", "current_relaxation", "follows", "sampled"),
)
PLAIN = without(MACHINE, *SELDOM)
WHEEL = np.dtype(
    [
        ("cos_heading", np.float64),  # of h from chassis x
        ("sin_heading", np.float64),
        ("offset", np.float64, (2,)),  # e: of the wheel centre from C, along h and k, m
        ("radius", np.float64),  # R, m
        ("roller_distance", np.float64),  # R1, m
        ("rollers", np.int64),  # N_r
        ("rates", np.uint32),  # where the first slot of its roller rates stands in the state
        ("contacts", np.uint32),  # which is the first of its contacts
        ("row", np.int64),  # which is the first of its rows of rollers
        ("rows", np.int64),  # how many it has
        ("alpha", np.float64),  # pi / N_r, rad
        ("sin_alpha", np.float64),
        ("cos_alpha", np.float64),
        ("cos_psi", np.float64),
        ("sin_psi", np.float64),
        ("tan_psi", np.float64),
        ("phase", np.float64),  # azimuth of roller 0 at spin angle 0, rad
        ("axle_inertia", np.float64),  # J_k, kg m^2
        ("rotor_inertia", np.float64),  # of the motor, reflected to the axle, kg m^2
        ("mass", np.float64),  # with its rollers, kg
        ("shift", np.float64),  # of its centre of mass along k, m
        ("diameter_inertia", np.float64),  # J_t, kg m^2
        ("disk_mass", np.float64),  # without rollers, kg
        ("disk_inertia", np.float64, (2,)),  # about its diameter and its axle, kg m^2
        ("roller_mass", np.float64),  # of one roller, kg
        ("transverse_inertia", np.float64),  # It of one roller, kg m^2
        ("axial_inertia", np.float64),  # Ia of one roller, kg m^2
        # 1 / (J_k + rotor): of what the drive has to turn, 1/(kg m^2); 0 where it follows angles
        ("spin_mobility", np.float64),
        ("holding_mobility", np.float64),  # the same for a sticking contact: not quite 0, see holding_mass
        ("rotor_part", np.float64),  # of the torque on the axle, for the rotor; 1 where the drive follows angles
        ("follows", np.int64),  # 1: its drive turns it as a table of angles says
        ("axial_mobility", np.float64),  # 1 / Ia, 1/(kg m^2)
        ("bearing_viscosity", np.float64),  # N m s
        ("bearing_torque", np.float64),  # N m
        ("bearing_rate", np.float64),  # over which the torque changes its sign, rad/s
        ("rolling_resistance", np.float64),  # f: moment on a roller by the load, m
        ("rolling_rate", np.float64),  # over which it changes its sign, rad/s
        ("drive_gain", np.float64),  # demand, N m or V, by the input of the drive
        ("drive_damping", np.float64),  # by the spin rate, s/rad
        ("drive_integral", np.float64),  # by the integrated error of the spin rate, 1/rad
        ("drive_derivative", np.float64),  # by the rate of change of the spin rate, s^2/rad
        ("drive_limit", np.float64),  # of the demand, N m or V
        ("sample_time", np.float64),  # of its controller, s
        ("sample_steps", np.int64),  # the same in steps; 0: it is not sampled
        ("motor", np.int64),  # 1: the demand is a voltage
        ("motor_constant", np.float64),  # K, N m/A
        ("resistance", np.float64),  # R_a, ohm
        ("inductance", np.float64),  # L, H
        ("current_limit", np.float64),  # A
        ("drive_viscosity", np.float64),  # friction of the motor, N m s
        ("drive_friction", np.float64),  # N m
        ("drive_friction_rate", np.float64),  # over which that changes its sign, rad/s
        ("odometry", np.float64, (3,)),  # chassis twist by the spin rate: m, m, 1
    ],
    align=True,
)
ROLLER_ROW = np.dtype(
    [
        ("phase", np.float64),  # azimuth of roller 0 at spin angle 0, were it on this row, rad
        ("offset", np.float64),  # of the row from the wheel's centre along k, m
    ]
)
FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE, DRIVE_INPUT = range(5)  # channels of the inputs; the last is of wheel 0
SERVO, CONTACTS, FREE = 0, 1, 2

# What the right-hand side finds at a contact (two of each wheel) and at a wheel.
CONTACT = np.dtype(
    [
        ("rest", np.int64),  # at zero slip
        ("axis", np.float64, (3,)),  # of the roller, along h, k and n
        ("l", np.float64),  # where it is along the axle, m
        ("slip", np.float64, (2,)),  # along h and k, m/s
        ("turn", np.float64),  # of the roller about the normal, rad/s
        ("arm", np.float64, (2,)),  # slip by the roller's rate, and torque of the force on the roller, m
        ("spin", np.float64, (2,)),  # the same of the spin, m
        ("lever", np.float64, (5, 2)),  # of the force in the rows x, y, yaw, and of tilt.py
        ("twist", np.float64, (5,)),  # of the contact torque there
        (
            "holding",
            np.float64,
            (2, 4),
        ),  # force that keeps its slip: by the body's acceleration (x, y, yaw); without, N
        ("bias", np.float64, (2,)),  # slip acceleration without its force and the body's acceleration, m/s^2
        ("factor", np.float64),  # g of the friction law F = -g v, by the normal force; of viscous friction N s/m
        ("unit", np.float64, (2,)),  # friction of its slip by the normal force, 1
        ("unit_torque", np.float64),  # contact torque by the normal force, m
        ("constant", np.float64, (2,)),  # friction that does not depend on the normal force, N
        *TURNING,
        ("begun", np.float64, (2,)),  # that direction as the mode has it, and the rate at which it turns: rad/s, and
        ("veer", np.float64, (2,)),  # 1/s by the angle from there
        ("turned", np.float64),  # by the last correction in the search for it, rad
        ("force", np.float64, (2,)),  # of the floor on the roller, N
        ("torque", np.float64),  # about the normal, N m
        ("share", np.float64),  # of the load of its wheel, 1
        ("pressed", np.float64),  # normal force, by which its rolling resistance is in the balance, N
        ("moment", np.float64, (2,)),  # of rolling resistance along h and k, by the normal force, m
        ("resisting", np.float64, (5,)),  # that moment in the rows of `lever`, m
        ("rolling", np.float64),  # its torque on the roller about its axis, by the normal force, m
        ("turning", np.float64),  # the same on the spin, m
        ("rolling_heat", np.float64),  # by the normal force, m/s
        ("relaxing", np.float64),  # the rate at which it stops the roller, at most, by the normal force, 1/(N s)
    ]
)
PART = np.dtype(
    [
        ("loaded", np.int64),  # 1: the floor carries the wheel
        ("first", np.uint32),  # of its contacts, as the record of the wheel has it
        ("contacts", np.int64),  # 1, or 2 while it rests on two rollers
        ("slides", np.int64),  # 1: its friction follows from its own slip and its load
        ("sought", np.int64),  # 1: its forces are sought by iteration, see contact_forces.py
        ("point", np.float64, (2,)),  # where its load acts, from C along chassis axes, m
        ("push", np.float64, (5,)),  # of a sliding wheel in the rows of tilt.py by its load: 1, 1, m, m, m
        ("rolling", np.float64),  # torque on its roller about its axis by its load, m
        ("turning", np.float64),  # the same on its spin, m
        ("heat", np.float64),  # by its load, m/s
        ("demand", np.float64),  # of the drive, N m or V
        ("voltage", np.float64),  # of the motor, V
        ("current", np.float64),  # A
        ("drive_torque", np.float64),  # tau on the disk about k, N m
        ("free_spin", np.float64),  # J phi'' without the contacts, N m
        ("followed", np.float64),  # phi'' that a table of angles asks for, rad/s^2; else 0
        ("tilt", np.float64, (2,)),  # the wheel without its contacts in the rows of tilt, N m
        ("normal_force", np.float64),  # N, N; below 0 of a wheel that the floor does not carry
        ("share_margin", np.float64),  # torque with which both contacts alone would push back to the edge, N m
    ]
)
LOADS = np.dtype(
    [
        ("tilt", np.float64, (2, 4)),  # rows of tilt without loads: by the acceleration (x, y, yaw), right side
        ("servo", np.float64, (2,)),  # torque about chassis x and y that keeps the bodies upright, N m
        # slip acceleration of one of RESTING by the force of another, 1/kg
        ("mobility", np.float64, (TOUCHING, TOUCHING, 2, 2)),
    ]
)
RESTING = np.dtype(
    [
        ("rest", np.int64),  # its force is sought
        ("limit", np.float64),  # of the force, N
        ("bias", np.float64, (2,)),  # slip acceleration without the force of any of them, m/s^2
        ("alone", np.float64, (2,)),  # the same without their rolling resistance, m/s^2
        ("by_load", np.float64, (TOUCHING, 2)),  # what that of each does, by its normal force, 1/kg
        ("force", np.float64, (2,)),  # N
    ]
)


# What the bodies of a scene are found to carry, and what stands between their joints.
ARTICULATED = np.dtype(
    [
        ("axle", np.float64, (3,)),  # k, world axes
        ("inertia", np.float64, (6,)),  # of the wheel about O without the spins of its rollers: xx, xy, xz, yy, yz, zz
        ("lift", np.float64, (3,)),  # sum of m (r - O), kg m
        ("mass", np.float64),  # kg
        ("spin_inertia", np.float64),  # about the axle, with the rotor, kg m^2
        ("torque", np.float64, (3,)),  # of its motion and weight about O, N m
        ("force", np.float64, (3,)),  # the same, N
        ("drive", np.float64),  # torque on the disk about k, N m
    ]
)
JOINT = np.dtype(
    [
        ("force", np.float64, (3,)),  # of the joint on the body that it carries, world axes, N
        ("moment", np.float64, (3,)),  # about the joint, N m
    ]
)


class Workspace(NamedTuple):
    """Workspace for the forces of an instant, W wheels of at most N rollers; not constant, but without memory either.

    contacts: (2 W,) records CONTACT, two for each wheel. parts: (W,) records PART. loads: record LOADS. resting (2,):
    records RESTING of the contacts of one wheel; None with a smooth law, under which none comes to rest. articulated
    (W,): records ARTICULATED, joints (W, N + 1): records JOINT of each wheel's disk and rollers; None in the reduced
    formulation. beside (2, 3, N): loads of the rollers of the wheel that is looked at (bearing_loads.py), 0 between
    uses but for the row that every use writes anew, of rates that are states.
    """

    contacts: np.recarray
    parts: np.recarray
    loads: np.record
    resting: np.recarray | None
    articulated: np.recarray | None
    joints: np.recarray | None
    beside: np.ndarray


class Parameters(NamedTuple):
    """Constants of a run, W wheels of at most N rollers, S pieces between knots of the tables.

    What a scene does not have is None, here, in Workspace, in Run and in Recording. That is known from the types of the
    arguments of a kernel, and what it would do with it is not compiled: see compiler.py.

    machine: record MACHINE or PLAIN. wheels: (W,) records WHEEL. roller_rows: records ROLLER_ROW of the rows of rollers
    of all wheels. sector: (W, 3, N) cosine and sine of 2 pi i / N_r, and the offset of the roller's row, m. starts:
    (S,) where the pieces begin, s. inputs: (S, 4 + W, 2) value at the start of the piece and slope of every channel.
    workspace: Workspace. space: Space, None of a machine that is upright.
    """

    machine: np.record
    wheels: np.recarray
    roller_rows: np.recarray
    sector: np.ndarray
    starts: np.ndarray
    inputs: np.ndarray
    workspace: Workspace
    space: Space | None
