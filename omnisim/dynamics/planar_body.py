"""The machine as one body in the plane: Newton and Euler for its acceleration.

    M A = sum F + f + M g_t                A_x, A_y of C along chassis axes; g_t: gravity along the floor
    I_z theta'' = sum lever . F + ...

All forces are linear in the acceleration X = (A_x, A_y, theta''): sliding friction does not know it, and a sticking
contact gives as far as its spin and roller do, F = -E (b + J X). What the floor carries: normal_forces.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec2
from omnisim.contact.frame import axes, frame_on_chassis, tangential
from omnisim.contact.mobility import Symmetric, holding_mass, yielding_along
from omnisim.dynamics.twist import Acceleration


class BodyEquations(NamedTuple):
    """The equations of the body: what resists the acceleration, a symmetric matrix over (x, y, yaw), and what drives
    it; SI."""

    xx: float
    xy: float
    xw: float
    yy: float
    yw: float
    ww: float
    x: float
    y: float
    yaw: float


class Mobility(NamedTuple):
    """The inverse of that matrix: acceleration by forces and a moment on the body."""

    coupled: bool  # or diagonal
    xx: float
    xy: float
    xw: float
    yy: float
    yw: float
    ww: float


@kernel
def set_contact(contact, state, j, spin_held):
    """Kinematics of a contact from its ContactState and Jacobian."""
    axis, slip = state.axis, state.slip
    contact.axis[0], contact.axis[1], contact.axis[2] = axis.h, axis.k, axis.n
    contact.l = state.contact.l
    contact.turn = state.turn
    contact.share = 0.5 if spin_held else 1.0
    contact.slip[0], contact.slip[1] = slip.h, slip.k
    contact.arm[0], contact.arm[1] = j.roller_h, j.roller_k
    contact.spin[0], contact.spin[1] = j.spin_h, j.spin_k


@kernel
def set_lever(wheel, contact, axis, j):
    """The levers of a contact in the rows x, y and yaw."""
    lever = contact.lever
    h, k, _ = axes(frame_on_chassis(wheel))
    lever[0, 0], lever[0, 1], lever[1, 0], lever[1, 1] = h.x, k.x, h.y, k.y
    lever[2, 0], lever[2, 1] = j.yaw_h, j.yaw_k
    contact.twist[2] = 1.0 - axis.n * axis.n


@kernel
def set_holding(machine, wheel, contact, axis, j, bias):
    """The force of a sticking contact, from its levers; bias (Slip): its slip acceleration without it, or its slip."""
    hold_by(holding_mass(machine, wheel, axis, j), contact, bias)


@kernel
def hold_by(e, contact, bias):
    """The same by its E (Symmetric, kg)."""
    lever, holding = contact.lever, contact.holding
    for i in range(3):
        holding[0, i] = -e.hh * lever[i, 0] - e.hk * lever[i, 1]
        holding[1, i] = -e.hk * lever[i, 0] - e.kk * lever[i, 1]
    holding[0, 3] = -e.hh * bias.h - e.hk * bias.k
    holding[1, 3] = -e.hk * bias.h - e.kk * bias.k


@outlined
def hold_against_rolling(machine, wheel, contact, axis, j):
    """What a sticking contact holds of its rolling resistance, by its load, into `unit`: the force that takes away
    what that does to its spin and its roller."""
    e = holding_mass(machine, wheel, axis, j)
    h, k = slip_by_rolling(wheel, contact)
    contact.unit[0], contact.unit[1] = -e.hh * h - e.hk * k, -e.hk * h - e.kk * k


@kernel
def slip_by_rolling(wheel, contact, spin_held=False):
    """Slip acceleration (h, k) that rolling resistance gives a contact by its own spin and roller, by the normal force,
    1/kg."""
    spin = 0.0 if spin_held else contact.turning * wheel.spin_mobility
    roller = contact.rolling * wheel.axial_mobility
    return contact.spin[0] * spin + contact.arm[0] * roller, contact.spin[1] * spin + contact.arm[1] * roller


@kernel
def free_rate(contact, motion):
    """Slip acceleration (h, k) of a contact without its own force, m/s^2: b + J X; motion: X, the Acceleration."""
    lever, bias = contact.lever, contact.bias
    return (
        bias[0] + lever[0, 0] * motion.x + lever[1, 0] * motion.y + lever[2, 0] * motion.yaw,
        bias[1] + lever[0, 1] * motion.x + lever[1, 1] * motion.y + lever[2, 1] * motion.yaw,
    )


@kernel
def holding_force(contact, motion):
    """F = -E (b + J X) along h and k of a sticking contact, N."""
    holding = contact.holding
    return (
        holding[0, 3] + holding[0, 0] * motion.x + holding[0, 1] * motion.y + holding[0, 2] * motion.yaw,
        holding[1, 3] + holding[1, 0] * motion.x + holding[1, 1] * motion.y + holding[1, 2] * motion.yaw,
    )


@kernel
def push_of(machine, contact, force_h, force_k, torque, normal):
    """A contact's force (N) and torque (N m), and its rolling resistance by the normal force (N), in the rows x, y and
    yaw."""
    lever = contact.lever
    x = lever[0, 0] * force_h + lever[0, 1] * force_k
    y = lever[1, 0] * force_h + lever[1, 1] * force_k
    yaw = lever[2, 0] * force_h + lever[2, 1] * force_k
    if machine.patch_radius > 0.0:
        yaw += contact.twist[2] * torque
    if machine.rolling:
        yaw += contact.resisting[2] * normal
    return x, y, yaw


@kernel
def holds(part, contact):
    """Whether a contact sticks and its force follows from the acceleration of the body."""
    return contact.rest and not part.sought


@kernel
def free_equations(machine, x, y, yaw):
    """The BodyEquations of a machine under a force (x, y) and a moment alone."""
    return BodyEquations(machine.mass, 0.0, 0.0, machine.mass, 0.0, machine.yaw_inertia, x, y, yaw)


@kernel
def pushed_equations(equations, x, y, yaw):
    """BodyEquations with one more force and moment."""
    return BodyEquations(
        equations.xx,
        equations.xy,
        equations.xw,
        equations.yy,
        equations.yw,
        equations.ww,
        equations.x + x,
        equations.y + y,
        equations.yaw + yaw,
    )


@kernel
def inclined_equations(machine, body, equations):
    """BodyEquations with the weight along an inclined floor, which acts at C."""
    x, y = machine.mass * machine.downhill[0], machine.mass * machine.downhill[1]
    weight = tangential(body.frame, Vec2(x, y))
    return pushed_equations(equations, weight.h, weight.k, 0.0)


@kernel
def held_equations(contact, equations):
    """BodyEquations with a sticking contact."""
    lever, holding = contact.lever, contact.holding
    x_h, x_k, y_h, y_k, w_h, w_k = lever[0, 0], lever[0, 1], lever[1, 0], lever[1, 1], lever[2, 0], lever[2, 1]
    return BodyEquations(
        equations.xx - x_h * holding[0, 0] - x_k * holding[1, 0],
        equations.xy - x_h * holding[0, 1] - x_k * holding[1, 1],
        equations.xw - x_h * holding[0, 2] - x_k * holding[1, 2],
        equations.yy - y_h * holding[0, 1] - y_k * holding[1, 1],
        equations.yw - y_h * holding[0, 2] - y_k * holding[1, 2],
        equations.ww - w_h * holding[0, 2] - w_k * holding[1, 2],
        equations.x + x_h * holding[0, 3] + x_k * holding[1, 3],
        equations.y + y_h * holding[0, 3] + y_k * holding[1, 3],
        equations.yaw + w_h * holding[0, 3] + w_k * holding[1, 3],
    )


@kernel
def inverse(machine, equations):
    """The Mobility of BodyEquations; diagonal unless some contact holds the body."""
    xx, xy, xw, yy, yw, ww = equations.xx, equations.xy, equations.xw, equations.yy, equations.yw, equations.ww
    if equations.xx == machine.mass:
        return Mobility(False, machine.mobility, 0.0, 0.0, machine.mobility, 0.0, machine.yaw_mobility)
    c_xx, c_xy, c_xw = yy * ww - yw * yw, xw * yw - xy * ww, xy * yw - xw * yy
    scale = 1.0 / (xx * c_xx + xy * c_xy + xw * c_xw)
    return Mobility(
        True, c_xx * scale, c_xy * scale, c_xw * scale,
        (xx * ww - xw * xw) * scale, (xy * xw - xx * yw) * scale, (xx * yy - xy * xy) * scale,
    )  # fmt: skip


@kernel
def yielding(mobility, x, y, yaw):
    """Acceleration of the body by the force (x, y) and the moment yaw."""
    if not mobility.coupled:
        return Acceleration(mobility.xx * x, mobility.yy * y, mobility.ww * yaw)
    return Acceleration(
        mobility.xx * x + mobility.xy * y + mobility.xw * yaw,
        mobility.xy * x + mobility.yy * y + mobility.yw * yaw,
        mobility.xw * x + mobility.yw * y + mobility.ww * yaw,
    )


@kernel
def contact_mobility(wheel, contact, mobility):
    """Slip acceleration (Symmetric, 1/kg) by the force of a contact that carries its wheel alone."""
    hh, hk, _, kk = through_body(contact, contact, mobility)
    a = yielding_along(Symmetric(hh, hk, kk), wheel.spin_mobility, contact.spin[0], contact.spin[1])
    return yielding_along(a, wheel.axial_mobility, contact.arm[0], contact.arm[1])


@kernel
def through_body(contact, source, mobility):
    """Slip acceleration of a contact by the force of another through the body alone (hh, hk, kh, kk), 1/kg."""
    push, feel = source.lever, contact.lever
    h = yielding(mobility, push[0, 0], push[1, 0], push[2, 0])
    k = yielding(mobility, push[0, 1], push[1, 1], push[2, 1])
    return (
        feel[0, 0] * h.x + feel[1, 0] * h.y + feel[2, 0] * h.yaw,
        feel[0, 0] * k.x + feel[1, 0] * k.y + feel[2, 0] * k.yaw,
        feel[0, 1] * h.x + feel[1, 1] * h.y + feel[2, 1] * h.yaw,
        feel[0, 1] * k.x + feel[1, 1] * k.y + feel[2, 1] * k.yaw,
    )
