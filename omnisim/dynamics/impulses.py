"""Impulses at the contacts that give slip the value it has come to: what is left of it when it ends is taken away."""

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Axis, Slip, outward
from omnisim.contact.kinematics import Jacobian, slip_jacobian
from omnisim.contact.mobility import holding_mass, inverse_mass, solution, turning_mass
from omnisim.contact.set_valued import CREEP, SLIP
from omnisim.dynamics.indices import rate_place
from omnisim.dynamics.planar_body import (
    free_equations,
    held_equations,
    hold_by,
    holding_force,
    inverse,
    set_contact,
    set_lever,
    yielding,
)
from omnisim.dynamics.spatial.aligning import align_in_space
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import body_motion, in_world, world_frame
from omnisim.dynamics.wheel import contact_state

FIRM_ROUNDS = 6  # where spins that follow angles are taken to turn as easily as HEAVY says


@outlined
def align_slip(parameters, run, seen):
    """Change the speeds by the impulses that leave no slip to sticking contacts, and none across their direction to
    creeping ones, all at once; next to none in so many rounds where spins follow angles. seen: whether the last
    right-hand side has seen this very state, so that its contacts are in the workspace.

    Friction turns creeping slip by forces across it, and so do these impulses.
    """
    if parameters.space is not None:
        align_in_space(parameters, run.mode, run.y, run.clock.dt)
    else:
        rounds = FIRM_ROUNDS if parameters.machine.follows else 1
        for i in range(rounds):
            align_slip_once(parameters, run, seen and i == 0)


@kernel
def align_slip_once(parameters, run, seen):
    """The equations of planar_body.py for sticking contacts, with their slip in the place of the slip acceleration."""
    machine = parameters.machine
    workspace = parameters.workspace
    y = run.y
    at = places(parameters)
    body = body_motion(parameters, run.y)
    equations = free_equations(machine, 0.0, 0.0, 0.0)
    for w in range(len(run.mode)):
        mode, wheel = run.mode[w], parameters.wheels[w]
        contact = workspace.contacts[wheel.contacts]
        if mode.grip[0] != SLIP and not mode.shared:
            if not seen:
                state = contact_state(parameters, mode, w, 0, body, y)
                j = slip_jacobian(wheel, state.axis, state.contact)
                set_contact(contact, state, j, False)
                set_lever(wheel, contact, state.axis, j)
            axis = Axis(contact.axis[0], contact.axis[1], contact.axis[2])
            j = Jacobian(contact.spin[0], contact.spin[1], 0.0, 0.0, contact.arm[0], contact.arm[1])
            slip, u = Slip(contact.slip[0], contact.slip[1]), mode.creep[0]
            if mode.grip[0] == CREEP:
                along, e = slip.h * u[0] + slip.k * u[1], turning_mass(machine, wheel, axis, j, u[0], u[1])
                rest = Slip(slip.h - along * u[0], slip.k - along * u[1])
            else:
                e = holding_mass(machine, wheel, axis, j)
                rest = Slip(slip.h - mode.layer[0], slip.k - mode.layer[1])
            contact.bias[0], contact.bias[1] = rest.h, rest.k
            hold_by(e, contact, rest)
            equations = held_equations(contact, equations)
    change = yielding(inverse(machine, equations), equations.x, equations.y, equations.yaw)
    for w in range(len(run.mode)):
        if run.mode[w].grip[0] != SLIP and not run.mode[w].shared:
            wheel = parameters.wheels[w]
            contact = workspace.contacts[wheel.contacts]
            impulse_h, impulse_k = holding_force(contact, change)
            mean_h, mean_k = contact.slip[0] - 0.5 * contact.bias[0], contact.slip[1] - 0.5 * contact.bias[1]
            y[at.friction_loss] -= impulse_h * mean_h + impulse_k * mean_k
            spin = contact.spin[0] * impulse_h + contact.spin[1] * impulse_k
            roller = contact.arm[0] * impulse_h + contact.arm[1] * impulse_k
            y[at.spin_rate + w] += spin * wheel.spin_mobility
            if wheel.follows:  # its drive holds the rate against the impulse
                y[at.drive_work] -= spin * y[at.spin_rate + w]
            y[rate_place(parameters, run.mode[w], w, 0)] += roller * wheel.axial_mobility
    linear = in_world(body, change)
    y[at.velocity] += linear.x
    y[at.velocity + 1] += linear.y
    y[at.yaw_rate] += change.yaw


@outlined
def change_slip(parameters, run, w, side, slip):
    """Change the speeds by the one impulse at a contact of wheel w that gives it the slip velocity `slip`."""
    machine = parameters.machine
    wheel = parameters.wheels[w]
    mode = run.mode[w]
    at = places(parameters)
    y = run.y
    body = body_motion(parameters, y)
    state = contact_state(parameters, mode, w, side, body, y)
    mobility = inverse_mass(machine, wheel, state.axis, state.contact, mode.shared)
    impulse = solution(mobility, Slip(slip.h - state.slip.h, slip.k - state.slip.k))
    j = slip_jacobian(wheel, state.axis, state.contact)
    push = outward(world_frame(wheel, body), impulse)
    y[at.velocity] += push.x * machine.mobility
    y[at.velocity + 1] += push.y * machine.mobility
    if not mode.shared:
        y[at.spin_rate + w] += (j.spin_h * impulse.h + j.spin_k * impulse.k) * wheel.spin_mobility
    y[at.yaw_rate] += (j.yaw_h * impulse.h + j.yaw_k * impulse.k) * machine.yaw_mobility
    y[rate_place(parameters, mode, w, side)] += (j.roller_h * impulse.h + j.roller_k * impulse.k) * wheel.axial_mobility
    mean_h, mean_k = 0.5 * (slip.h + state.slip.h), 0.5 * (slip.k + state.slip.k)
    y[at.friction_loss] -= impulse.h * mean_h + impulse.k * mean_k
