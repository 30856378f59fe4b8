"""Contact tracking alone, for what it costs."""

import math

from omnisim.base.kernel import kernel
from omnisim.contact.tracking import explicit_contact, implicit_contact, roller_axis
from omnisim.dynamics.right_hand_side import rho_rates
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import body_motion, world_frame
from omnisim.dynamics.wheel import azimuth, rho_of


@kernel
def track(parameters, states, slopes, rounds):
    """Evaluate the tracking in every state, `rounds` times, with roller 0 in contact; returns a sum of it all.

    Counted is all that the right-hand side does to know the contact point, and nothing else:

        explicit    cosine and sine of the azimuth; the closed form
        implicit    cosine and sine of yaw and azimuth, orientation of the roller, contact point from rho;
                    then for every roller, in the air too, its orientation and rho', written to the slopes

    Kinematics and friction, which need the yaw's cosine and sine with either tracking, are not.
    """
    total = 0.0
    for _ in range(rounds):
        for i in range(len(states)):
            if parameters.machine.implicit_tracking:
                total += track_implicitly(parameters, states[i], slopes[i])
            else:
                total += track_explicitly(parameters, states[i])
    return total


@kernel
def track_explicitly(parameters, y):
    at = places(parameters)
    total = 0.0
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        q = azimuth(wheel, parameters.roller_rows[wheel.row], 0, y[at.spin_angle + w])
        contact = explicit_contact(wheel, math.cos(q), math.sin(q))
        total += contact.l + contact.arm_h + contact.arm_k
    return total


@kernel
def track_implicitly(parameters, y, slopes):
    at = places(parameters)
    body = body_motion(parameters, y)
    total = 0.0
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        q = azimuth(wheel, parameters.roller_rows[wheel.row], 0, y[at.spin_angle + w])
        axis = roller_axis(wheel, math.cos(q), math.sin(q))
        contact = implicit_contact(wheel, world_frame(wheel, body), axis, rho_of(parameters, y, w, 0))
        total += contact.l + contact.arm_h + contact.arm_k
    rho_rates(parameters, body, y, slopes)
    return total
