"""How easily the contacts of a machine free in space slip: the slip acceleration that a contact force causes.

In the speeds (w, V of C; sigma~; p) the inertia of wheel and machine is diagonal but for that of the machine, with
sigma~ = phi' + J_k / (J_k + J_r) w . k of inertia J_k + J_r (the rest of the rotor leans on its carrier, wheel.py). A
force F at X moves them by

    force F and moment r x F + m - J_k / (J_k + J_r) (k . m) k on the machine          m = (X - O) x F - a (arm . F)
    torque k . m on sigma~          torque arm . F on p          arm = a x (X - B)

and what moves by a unit force along e slips by the same numbers along e.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, combine, cross, dot, plus
from omnisim.contact.mobility import Symmetric
from omnisim.dynamics.spatial.pose import mounted, outward, product, tangent_of


class Lever(NamedTuple):
    """What a unit force at a contact does: moment about C and force on the machine, chassis axes; torques on sigma~ and
    on the roller (m)."""

    moment: Vec3
    force: Vec3
    spin: float
    roller: float


@kernel
def lever_along(parameters, w, hub, touched, e):
    """The Lever of a unit force along e (hub axes) where a roller of wheel w touches, a Touching."""
    axis = touched.roller.axis
    roller = dot(cross(axis, touched.lever), e)
    turned = combine(1.0, cross(plus(touched.roller.centre, touched.lever), e), -roller, axis, 0.0, e)
    leaning = parameters.space.hubs[w].coupled * turned.y
    axes = mounted(hub)
    force = outward(axes, e)
    moment = outward(axes, Vec3(turned.x, turned.y - leaning, turned.z))
    return Lever(plus(moment, cross(hub.centre, force)), force, turned.y, roller)


@kernel
def contact_mobility(parameters, w, hub, touched):
    """Slip acceleration along h and k by the force where a roller of wheel w touches (Symmetric, 1/kg), with carriers
    held."""
    h, k = tangent_of(touched.normal)
    along, across = lever_along(parameters, w, hub, touched, h), lever_along(parameters, w, hub, touched, k)
    return Symmetric(
        through(parameters, w, along, along),
        through(parameters, w, along, across),
        through(parameters, w, across, across),
    )


@kernel
def through(parameters, w, felt, pushed):
    """Slip acceleration along one direction by a unit force along another, both at one contact of wheel w, 1/kg."""
    own, wheel = parameters.space.body, parameters.wheels[w]
    machine = own.mobility * dot(felt.force, pushed.force) + dot(felt.moment, product(own.turning, pushed.moment))
    axles = wheel.spin_mobility * felt.spin * pushed.spin + wheel.axial_mobility * felt.roller * pushed.roller
    return machine + axles
