"""What rubber and friction do where a roller touches the ground.

    V    velocity of the roller's material at X       delta' = -V . nu
    N    = max(0, stiffness delta + damping delta')    v = V - (V . nu) nu, friction by the scene's law

All along hub axes; X, nu and delta as in touching.py.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.contact.frame import Slip
from omnisim.contact.friction import friction
from omnisim.contact.set_valued import SLIP
from omnisim.dynamics.spatial.running import streaming
from omnisim.dynamics.spatial.touching import disk_turning


class Reaction(NamedTuple):
    """What the ground does at a contact: delta' (m/s), stiffness delta + damping delta' and N (N), slip (m/s) and
    friction (N) in the tangent plane, factor of the law (N s/m), force (N), moment about the normal (N m), heat (W)
    and moment of the force about the roller's axis (N m)."""

    closing: float
    press: float
    normal_force: float
    slip: Slip
    friction: Slip
    factor: float
    force: Vec3
    torque: float
    heat: float
    rolling: float


@kernel
def react(parameters, mode, w, c, stand, touched, rate):
    """The Reaction at contact c of wheel w, whose roller has the absolute axial rate `rate`, rad/s."""
    machine, own, hub = parameters.machine, parameters.space.hubs[w], stand.hub
    normal, roller = touched.normal, touched.roller
    turning = disk_turning(stand)
    joint = rate - dot(roller.axis, turning)
    swing = times(touched.deep, cross(roller.axis, normal))
    velocity = plus(plus(hub.velocity, cross(turning, touched.arm)), times(joint, swing))
    closing = -dot(velocity, normal)
    press = own.stiffness * touched.depth + own.damping * closing
    load = press if mode.pressed[c] else 0.0
    sliding = plus(velocity, times(closing, normal))
    along_h = velocity.x * normal.z - velocity.z * normal.x
    slip = Slip(along_h * touched.stretch, sliding.y * touched.stretch)
    factor, torque, turn = 0.0, 0.0, 0.0
    if mode.pressed[c]:
        if machine.patch_radius > 0.0:
            turn = dot(turning, normal) + joint * touched.tilt
        stream = slip
        if machine.brush:
            stream = streaming(parameters, mode, w, c, (stand, touched), joint)
        factor, torque = friction(machine, mode.saturated[c], load, slip, turn, stream)
    given, heat = factor, factor * (slip.h * slip.h + slip.k * slip.k) - torque * turn
    if parameters.workspace.resting is not None and mode.grip[c] != SLIP:  # its force is found with those of others
        given, heat = 0.0, 0.0
    held = Slip(-given * slip.h, -given * slip.k)
    force = minus(times(load, normal), times(given, sliding))
    return Reaction(closing, press, load, slip, held, factor, force, torque, heat, dot(swing, force))
