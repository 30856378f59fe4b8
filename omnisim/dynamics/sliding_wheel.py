"""The short way of a wheel that slides on one roller: its forces straight from its own slip, by its load.

It computes what wheel_forces.py computes of any wheel (`observe_wheel`, `move_wheel`), term by term, which
tests/dynamics/test_sliding_wheel.py holds to rounding. It is there for speed alone: most wheels slide most of the time,
and numbers that stay in registers are faster than those that wait in the workspace. Measured, nanoseconds for one step
of rk4, minima of 450 marches in turn, all wheels by the one way or by the other:

    bare wheel, 6 rollers     288   340          four wheels that carry roll and pitch     2570   2650
"""

from omnisim.base.kernel import kernel
from omnisim.contact.frame import Slip, frame_on_chassis, outward
from omnisim.contact.friction import friction
from omnisim.contact.kinematics import slip_jacobian
from omnisim.contact.set_valued import SLIP
from omnisim.dynamics.actuation import follow_angles
from omnisim.dynamics.indices import rate_place
from omnisim.dynamics.normal_forces.solution import loads_known
from omnisim.dynamics.normal_forces.tilt import TILT_X, TILT_Y, rotor_part, set_point, tilt_rows
from omnisim.dynamics.planar_body import pushed_equations, set_contact
from omnisim.dynamics.state import places
from omnisim.dynamics.wheel_forces import free_wheel, monitor_wheel, set_part, twist, yield_to


@kernel
def slides_alone(machine, mode):
    """Whether a wheel goes this way: it slides on one roller, by a law of slip and load alone that needs no more than
    its load, if that is not known; and nothing resists its rolling."""
    alone = mode.grip[0] == SLIP and not mode.shared and not machine.rolling and not machine.brush
    return alone and (loads_known(machine) or not machine.viscous)


@kernel
def slide_wheel(parameters, stage, w, body, load, equations):
    """A wheel that slides under a known load, N: the rates that follow; the BodyEquations with it, heat and power (W).

    If loads are not known yet, `load` is 1 N, and what that does goes into the workspace.
    """
    machine = parameters.machine
    wheel = parameters.wheels[w]
    mode = stage.mode[w]
    dy = stage.dy
    free = free_wheel(parameters, stage, w, body)
    state = free.state
    axis = free.state.axis
    slip = free.state.slip
    j = slip_jacobian(wheel, axis, state.contact)
    factor, torque = friction(machine, mode.saturated[0], max(load, 0.0), slip, state.turn, slip)
    force = Slip(-factor * slip.h, -factor * slip.k)
    rolling, spin, loss = yield_to(j, slip, force)
    yaw = j.yaw_h * force.h + j.yaw_k * force.k
    if machine.patch_radius > 0.0:
        rolling, spin, loss = twist(axis, state.turn, torque, rolling, spin, loss)
        yaw += (1.0 - axis.n * axis.n) * torque
    if stage.monitoring:
        contact = parameters.workspace.contacts[wheel.contacts]
        monitors = stage.monitors[w]
        monitor_wheel(free, load, monitors)
        set_contact(contact, state, j, False)
        contact.force[0] = force.h
        contact.force[1] = force.k
        contact.torque = torque
        contact.factor = factor
        monitors.slip_square[0], monitors.factor[0], monitors.margin[0] = slip.h * slip.h + slip.k * slip.k, factor, 0.0
    power = free.drive * state.twist.spin
    push = outward(frame_on_chassis(wheel), force)
    if not loads_known(machine):
        set_part(parameters, stage, w, free, body, load)
        part = parameters.workspace.parts[w]
        set_point(wheel, part, state.contact.l)
        part.push[0], part.push[1], part.push[2] = push.x, push.y, yaw
        about_h = machine.height * force.k - axis.h * rolling
        about_k = (wheel.radius - machine.height) * force.h + rotor_part(wheel, False) * spin
        part.push[TILT_Y], part.push[TILT_X] = tilt_rows(wheel, about_h, about_k)
        part.rolling, part.turning, part.heat = rolling, spin, loss
        return pushed_equations(equations, 0.0, 0.0, free.yaw_moment), 0.0, power
    if stage.monitoring:
        set_part(parameters, stage, w, free, body, load)
    dy[rate_place(parameters, mode, w, 0)] += rolling * wheel.axial_mobility
    dy[places(parameters).spin_rate + w] = (free.spin + spin) * wheel.spin_mobility
    if machine.follows:
        power += follow_angles(parameters, stage, w, free.spin + spin)
    return pushed_equations(equations, push.x, push.y, free.yaw_moment + yaw), loss, power


@kernel
def press_wheel(parameters, stage, w):
    """Rates of a wheel that slides under the load that has been found for it; its heat, and the power of a drive that
    follows angles, W."""
    wheel = parameters.wheels[w]
    part = parameters.workspace.parts[w]
    mode = stage.mode[w]
    dy = stage.dy
    normal = max(part.normal_force, 0.0) if mode.loaded else 0.0
    dy[rate_place(parameters, mode, w, 0)] += part.rolling * normal * wheel.axial_mobility
    spin = part.free_spin + part.turning * normal
    dy[places(parameters).spin_rate + w] = spin * wheel.spin_mobility
    if stage.monitoring:
        contact = parameters.workspace.contacts[wheel.contacts]
        monitors = stage.monitors[w]
        contact.force[0], contact.force[1] = contact.force[0] * normal, contact.force[1] * normal
        contact.torque *= normal
        monitors.factor[0] = contact.factor * normal
        monitors.normal_force = part.normal_force
    power = follow_angles(parameters, stage, w, spin) if parameters.machine.follows else 0.0
    return part.heat * normal, power
