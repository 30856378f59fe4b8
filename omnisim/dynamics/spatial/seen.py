"""Where wheels and contacts are at an instant, kept between passes over all of them.

From a spin angle to a force leads a chain of some 90 operations each of which waits for the last: sine, lowest point,
slip, friction. In one pass wheel after wheel would wait for the whole of it. So each pass takes a part of it for all
wheels, short enough for a processor to work on those of several at once.
"""

import numpy as np

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import minus
from omnisim.dynamics.spatial.pose import Hub, put, vector
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import Roller, Standing, Touching, standing, touching_at


@kernel
def look_at_all(parameters, mode, body, y):
    """The Standing of each wheel and the Touching of each contact into their records, in state y with these modes."""
    space = parameters.space
    for w in range(len(space.stands)):
        keep_standing(space.stands[w], standing(parameters, w, body, y))
    for w in range(len(space.stands)):
        for c in range(mode[w].contacts):
            if space.body.uneven:
                look_at_ground(parameters, mode[w], w, c, body)
            else:
                look_at_contact(parameters, mode[w], w, c, body)


@kernel
def touch_place(w, c):
    """Where the record TOUCH of contact c of wheel w stands; unsigned: nobody tests whether it counts from the end."""
    return np.uint32(w * SLOTS + c)


@kernel
def look_at_contact(parameters, mode, w, c, body):
    """The Touching of contact c of wheel w into its record; the Standing of the wheel is in its own."""
    space = parameters.space
    stand = standing_seen(space.stands[w], body)
    keep_touching(space.touches[touch_place(w, c)], touching_at(parameters, mode, w, c, stand))


@outlined
def look_at_ground(parameters, mode, w, c, body):
    """The same on uneven ground: called from here, what a plane does not ask for of a Standing is not read there."""
    look_at_contact(parameters, mode, w, c, body)


@kernel
def keep_standing(seen, stand):
    """A Standing into its record STAND."""
    hub = stand.hub
    put(seen.h, hub.h)
    put(seen.k, hub.k)
    put(seen.up, hub.up)
    put(seen.centre, hub.centre)
    put(seen.velocity, hub.velocity)
    put(seen.rate, hub.rate)
    put(seen.normal, stand.normal)
    seen.cos, seen.sin, seen.spin_rate = stand.cos, stand.sin, stand.spin_rate
    seen.stretch, seen.height = stand.stretch, stand.height


@kernel
def standing_seen(seen, body):
    """The Standing of a wheel of this Body, from its record STAND."""
    hub = Hub(
        vector(seen.h, 0),
        vector(seen.k, 0),
        vector(seen.up, 0),
        vector(seen.centre, 0),
        vector(seen.velocity, 0),
        vector(seen.rate, 0),
    )
    normal = vector(seen.normal, 0)
    return Standing(body, hub, seen.cos, seen.sin, seen.spin_rate, normal, seen.stretch, seen.height)


@kernel
def keep_touching(seen, touched):
    """A Touching into its record TOUCH."""
    roller = touched.roller
    seen.azimuth[0], seen.azimuth[1] = roller.cos_q, roller.sin_q
    put(seen.axis, roller.axis)
    put(seen.normal, touched.normal)
    put(seen.lever, touched.lever)
    put(seen.point, touched.arm)
    seen.stretch, seen.depth, seen.tilt = touched.stretch, touched.depth, touched.tilt
    seen.deep, seen.within = touched.deep, touched.within


@kernel
def touching_seen(seen):
    """The Touching of a record TOUCH."""
    lever, arm = vector(seen.lever, 0), vector(seen.point, 0)
    roller = Roller(seen.azimuth[0], seen.azimuth[1], vector(seen.axis, 0), minus(arm, lever))
    normal = vector(seen.normal, 0)
    return Touching(roller, normal, seen.stretch, seen.depth, seen.tilt, seen.deep, lever, arm, seen.within)
