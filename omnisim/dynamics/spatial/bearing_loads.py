"""What every bearing of a machine free in space carries, recovered from a motion that is known, as of a machine that
stands upright (dynamics/bearing_loads.py), along hub axes.

The disk is without the hub of a suspension, which is beyond the axle. Forces of the ground are those that the
right-hand side has left in `touches`.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import combine, cross, minus, plus, times
from omnisim.dynamics.bearing_loads import (
    AXLE,
    DiskMotion,
    Mounting,
    add,
    carried_by,
    disk_load,
    keep,
    load_in_air,
    load_of_floor,
    of_disk,
    on_axle,
)
from omnisim.dynamics.multibody.elimination import Wrench3
from omnisim.dynamics.spatial.acceleration import hub_acceleration
from omnisim.dynamics.spatial.pose import body_of, inward, mounted, tangent_of, vector
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import roller_on, standing
from omnisim.dynamics.state import places


@outlined
def recover_in_space(parameters, mode, w, y, dy, rates, found):
    """Force and moment of the bearings of wheel w: found (N + 1, 2, 3), of the axle first, N and N m; rates (N,):
    absolute axial rates of its rollers, rad/s."""
    wheel, every = parameters.wheels[w], parameters.machine.every_rate
    stand = standing(parameters, w, body_of(parameters, y), y)
    disk = motion_in_space(parameters, w, stand, y, dy)
    carried = carried_by(wheel, disk)
    axle = disk_load(wheel, disk)
    for i in range(wheel.rollers):
        mounting = mounting_of(parameters, w, i, stand)
        rolling = dy[wheel.rates + i] if every else 0.0
        given, force = load_in_air(wheel, mounting, disk, carried, rates[i], rolling)
        keep(found[i + 1], given)
        axle = on_axle(wheel, mounting, axle, given.moment, force)
    for c in range(mode.contacts):
        slot, first = mode.slot[c], True
        for other in range(c):  # two contacts of one roller have one rate
            first = first and mode.slot[other] != slot
        i = mode.roller[slot]
        mounting = mounting_of(parameters, w, i, stand)
        rolling = dy[wheel.rates + slot] if first and not every else 0.0
        more = load_of_floor(wheel, mounting, ground_at(parameters.space.touches[w * SLOTS + c]), rolling)
        add(found[i + 1], more)
        axle = on_axle(wheel, mounting, axle, more.moment, of_disk(wheel, mounting, more.force))
    keep(found[0], axle)


@kernel
def mounting_of(parameters, w, i, stand):
    """The Mounting of roller i of wheel w."""
    roller = roller_on(parameters, w, i, stand)
    return Mounting(roller.cos_q, roller.sin_q, roller.centre.y)


@kernel
def motion_in_space(parameters, w, stand, y, dy):
    """The DiskMotion of wheel w."""
    axes = mounted(stand.hub)
    lifted, turning = hub_acceleration(parameters, stand.body, w, y, dy)
    linear = minus(lifted, inward(stand.body.rotation, vector(parameters.space.body.gravity, 0)))
    spin = dy[places(parameters).spin_rate + w]
    bent = combine(1.0, inward(axes, turning), spin, AXLE, stand.spin_rate, cross(stand.hub.rate, AXLE))
    return DiskMotion(plus(stand.hub.rate, times(stand.spin_rate, AXLE)), inward(axes, linear), bent)


@kernel
def ground_at(touch):
    """The Wrench3 of the ground on a roller about its centre, from a record TOUCH."""
    normal = vector(touch.normal, 0)
    h, k = tangent_of(normal)
    force = combine(touch.normal_force, normal, touch.force[0], h, touch.force[1], k)
    about = combine(touch.torque, normal, touch.resistance[0], h, touch.resistance[1], k)
    return Wrench3(plus(cross(vector(touch.lever, 0), force), about), force)
