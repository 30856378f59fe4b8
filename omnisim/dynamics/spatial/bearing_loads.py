"""What every bearing of a machine free in space carries, recovered from a motion that is known, as of a machine that
stands upright (dynamics/bearing_loads.py), along hub axes.

The disk is without the hub of a suspension, which is beyond the axle. Forces of the ground are those that the
right-hand side has left in `touches`.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import combine, cross, minus, plus, times
from omnisim.dynamics.bearing_loads import (
    AXLE,
    NOTHING,
    back,
    centre_of,
    load_axle,
    load_by_floor,
    load_rollers,
    mounted_at,
    spin_up,
    spins,
    there,
    turned,
    unload,
)
from omnisim.dynamics.joint_loads import AXIAL, enter
from omnisim.dynamics.multibody.elimination import Wrench3
from omnisim.dynamics.spatial.acceleration import hub_acceleration
from omnisim.dynamics.spatial.pose import body_of, inward, mounted, tangent_of, vector
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import standing
from omnisim.dynamics.state import places


@outlined
def recover_in_space(parameters, mode, w, y, dy, rates, found):
    """Force and moment of the bearings of wheel w, of the axle first, into found (joint_loads.py); rates (N,): absolute
    axial rates of its rollers, rad/s."""
    every, wheel, placed = parameters.machine.every_rate, parameters.wheels[w], parameters.space.disk[w]
    beside = parameters.workspace.beside
    spun = spin_up(wheel, placed, dy, beside) if every else NOTHING
    axle = Wrench3(NOTHING, NOTHING)
    disk = motion_in_space(parameters, w, standing(parameters, w, body_of(parameters, y), y), y, dy)
    for c in range(mode.contacts):
        slot, first = mode.slot[c], True
        for other in range(c):  # two contacts of one roller have one rate
            first = first and mode.slot[other] != slot
        i = mode.roller[slot]
        rolling = dy[wheel.rates + slot] if first and not every else 0.0
        mounting = mounted_at(placed, i)
        ground = ground_at(parameters.space.touches[w * SLOTS + c], back(centre_of(wheel, mounting), disk))
        floor = Wrench3(there(ground.moment, disk.cos, disk.sin), there(ground.force, disk.cos, disk.sin))
        axle = load_by_floor(wheel, mounting, floor, rolling, axle, i, beside)
    load_rollers(wheel, placed, disk, rates, beside, found)
    enter(found, 0, AXIAL, load_axle(wheel, disk, spins(wheel, placed, rates, 0), spun, axle))
    for c in range(mode.contacts):
        unload(beside, mode.roller[mode.slot[c]])


@kernel
def motion_in_space(parameters, w, stand, y, dy):
    """The DiskMotion of wheel w."""
    axes = mounted(stand.hub)
    lifted, turning = hub_acceleration(parameters, stand.body, w, y, dy)
    linear = minus(lifted, inward(stand.body.rotation, vector(parameters.space.body.gravity, 0)))
    spin = dy[places(parameters).spin_rate + w]
    bent = combine(1.0, inward(axes, turning), spin, AXLE, stand.spin_rate, cross(stand.hub.rate, AXLE))
    rate = plus(stand.hub.rate, times(stand.spin_rate, AXLE))
    return turned(rate, inward(axes, linear), bent, stand.cos, -stand.sin)


@kernel
def ground_at(touch, centre):
    """The Wrench3 of the ground on a roller about O, from a record TOUCH; centre: B from O (Vec3, m)."""
    normal = vector(touch.normal, 0)
    h, k = tangent_of(normal)
    force = combine(touch.normal_force, normal, touch.force[0], h, touch.force[1], k)
    about = combine(touch.torque, normal, touch.resistance[0], h, touch.resistance[1], k)
    return Wrench3(plus(cross(plus(centre, vector(touch.lever, 0)), force), about), force)
