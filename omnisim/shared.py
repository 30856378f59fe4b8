"""A wheel that rests on two rollers: the multiplier that splits the load.

At a common edge both neighbours touch the floor. If each of them alone would turn the wheel back to the edge, it
rests on both: phi' = 0, and the load N is split into sigma N on the roller ahead (q = +alpha) and (1 - sigma) N on the
one behind such that phi'' = 0. It is the limit of ever shorter swings about the edge, sigma the part of the time that
they spend on the roller ahead; so a force that does not depend on N, viscous friction, is shared as well.

    turning(sigma) = tau - theta' G_h - sum (R F_h + s Ia p') = 0    turning(0) > 0 > turning(1)

Forces at zero slip (coulomb) follow from Gauss' principle for both contacts together, under the limits mu sigma N
and mu (1 - sigma) N.
"""

from omnisim.contact.coulomb import SLIP, contact_forces
from omnisim.contact.kinematics import Motion, coupling, inverse_mass, slip_acceleration, slip_jacobian
from omnisim.contact.reaction import COULOMB, friction
from omnisim.kernel import kernel, merged, outlined
from omnisim.wheel import all_rollers, bearing_torque, contact_state, free_motion

MOST_ITERATIONS = 100
SETTLED = 1e-15  # change of the share


@outlined
def share_load(parameters, mode, w, heading, normal, wrench, torque, y, watch):
    """Write the share of the roller ahead and how firmly the wheel rests on both into `watch`, forces into the room."""
    machine, wheel, room, c = parameters.machine, parameters.wheels[w], parameters.room, 2 * w
    ahead = contact_state(parameters, mode, w, 0, heading, y)
    behind = contact_state(parameters, mode, w, 1, heading, y)
    rollers = all_rollers(parameters, mode, w, ahead.cos_q, ahead.sin_q, y)
    motion = free_motion(parameters, wheel, ahead, rollers, heading, wrench, torque)
    free = wheel.axle_inertia * motion.spin
    set_contact(parameters, mode, c, wheel, ahead, motion, normal)
    set_contact(parameters, mode, c + 1, wheel, behind, motion, normal)
    j_0 = slip_jacobian(wheel, ahead.axis, ahead.contact)
    j_1 = slip_jacobian(wheel, behind.axis, behind.contact)
    hh, hk, kh, kk = coupling(machine, wheel, j_0, j_1, True)
    fill(room.mobility[c, c + 1], hh, hk, kh, kk)
    fill(room.mobility[c + 1, c], hh, kh, hk, kk)
    limit = machine.friction * normal
    low, high = 0.0, 1.0
    t_low, t_high = turning(room, c, limit, free, 0.0), turning(room, c, limit, free, 1.0)
    watch.share_margin = min(t_low, -t_high)
    share = 0.5
    if t_low > t_high:
        share = min(max(t_low / (t_low - t_high), 0.0), 1.0)
    if (room.contacts[c].rest or room.contacts[c + 1].rest) and t_low > 0.0 > t_high:
        side = 0
        for _ in range(MOST_ITERATIONS):  # regula falsi, Illinois variant
            t = turning(room, c, limit, free, share)
            if t > 0.0:
                low, t_low = share, t
                t_high *= 0.5 if side == 1 else 1.0
                side = 1
            else:
                high, t_high = share, t
                t_low *= 0.5 if side == -1 else 1.0
                side = -1
            last, share = share, (low * t_high - high * t_low) / (t_high - t_low)
            if t == 0.0 or abs(share - last) <= SETTLED:
                break
    turning(room, c, limit, free, share)
    watch.share = share


@merged
def set_contact(parameters, mode, c, wheel, state, motion, normal):
    """The contact equation of contact c with the spin held, and its force at full load, into the room."""
    machine, contact, side, roller = parameters.machine, parameters.room.contacts[c], c % 2, motion.roller
    contact.rest = machine.law == COULOMB and mode.grip[side] != SLIP
    factor, torque = friction(machine, mode.saturated[side], normal, state.slip, state.turn)
    contact.full[0], contact.full[1], contact.torque = -factor * state.slip.h, -factor * state.slip.k, torque
    hh, hk, kk = inverse_mass(machine, wheel, state.axis, state.contact, True)
    fill(parameters.room.mobility[c, c], hh, hk, hk, kk)
    if machine.bearings:
        roller = bearing_torque(wheel, state.joint) / wheel.axial_inertia
    b = slip_acceleration(wheel, state, Motion(motion.h, motion.k, 0.0, motion.yaw, roller))
    contact.bias[0], contact.bias[1] = b.h, b.k
    j = slip_jacobian(wheel, state.axis, state.contact)
    contact.lever[0], contact.lever[1], contact.lean = j.spin_h, j.spin_k, -state.axis.k * state.axis.n


@kernel
def fill(matrix, hh, hk, kh, kk):
    matrix[0, 0], matrix[0, 1], matrix[1, 0], matrix[1, 1] = hh, hk, kh, kk


@kernel
def turning(room, c, limit, free, share):
    """J_k phi'' of a wheel whose contacts c, c + 1 carry `share` and the rest, N m; leaves their forces in the room."""
    total = free
    for side in range(2):
        contact, part = room.contacts[c + side], share if side == 0 else 1.0 - share
        contact.limit = part * limit
        if not contact.rest:
            contact.force[0], contact.force[1] = part * contact.full[0], part * contact.full[1]
        total += part * contact.torque * contact.lean
    contact_forces(room, c, 2)
    for side in range(2):
        contact = room.contacts[c + side]
        total += contact.lever[0] * contact.force[0] + contact.lever[1] * contact.force[1]
    return total
