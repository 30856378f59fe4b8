"""How far the rollers of a wheel are from the ground that they do not touch."""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import dot, minus
from omnisim.contact.common_normal import ANY, room
from omnisim.contact.common_normal import Roller as Solid
from omnisim.contact.floor import pieces
from omnisim.dynamics.spatial.pose import body_of, put, vector
from omnisim.dynamics.spatial.seen import standing_seen
from omnisim.dynamics.spatial.touching import in_world, meetings, roller_on, shape_of, standing, touching

MOST_MEETINGS = 1009  # of rollers and their lobes, a prime
FAR = 1.0  # m: a gap where no common normal is found, which events can still be located with


@kernel
def in_contact(mode, i, meeting):
    """Whether roller i touches at this meeting."""
    found = False
    for c in range(mode.contacts):
        found = found or (mode.roller[mode.slot[c]] == i and mode.meeting[c] == meeting)
    return found


@kernel
def may_be_next(parameters, mode, w, i):
    """Whether roller i of wheel w may be the next to touch: on a plane, where a wheel is round enough, one that does or
    a neighbour of it."""
    rollers, rows = parameters.wheels[w].rollers, parameters.space.hubs[w].row_count
    near = mode.rollers == 0 or parameters.space.body.uneven != 0
    for slot in range(mode.rollers):
        away = abs(i - mode.roller[slot])
        near = near or min(away, rollers - away) <= rows
    return near


@outlined
def gap_of(parameters, y, w, i, meeting):
    """How far roller i of wheel w is from touching at a meeting in state y, m; < 0: it overlaps."""
    return gap_at(parameters, w, standing(parameters, w, body_of(parameters, y), y), i, meeting)


@kernel
def gap_at(parameters, w, stand, i, meeting):
    """The same of its Standing; on uneven ground something less, of a roller that is clearly apart."""
    if parameters.space.body.uneven:
        away = room_around(parameters, w, stand, i, meeting)
        if away > 0.0:
            return away
    touched = touching(parameters, w, stand, meeting, ANY, i)
    return min(-min(touched.depth, touched.within), FAR)


@kernel
def room_around(parameters, w, stand, i, meeting):
    """How far a roller is from a piece of the floor that it cannot touch at a meeting, m; <= 0 where it may: cheaper
    than a search for the point where it does."""
    space, floor = parameters.space, parameters.space.floor
    shape = shape_of(space, w, meeting)
    roller = roller_on(parameters, w, i, stand)
    height = stand.height + dot(roller.centre, stand.normal)
    lowest = height - shape.thickest - shape.half_length * abs(dot(roller.axis, stand.normal))
    if lowest > floor.highest:
        return lowest - floor.highest
    centre, axis = in_world(stand, roller)
    return room(floor, meeting % pieces(floor), Solid(shape, centre, axis))


@kernel
def least_gap(parameters, mode, w, body):
    """The least gap of wheel w between the ground and what does not touch it of its rollers, m, as its record STAND has
    it; on a plane something less, if it is apart: no roller comes nearer than the wheel has moved since it was last
    looked at with these contacts, whose points go as far as its centre does, its reach times what the normal turns by,
    and their lever times what the spin turns by.
    """
    if parameters.space.body.uneven:
        return least_gap_on_ground(parameters, mode, w, body)
    seen, own = parameters.space.stands[w], parameters.space.hubs[w]
    tilt = minus(vector(seen.normal, 0), vector(seen.clear_normal, 0))
    cos, sin = seen.cos - seen.clear_turn[0], seen.sin - seen.clear_turn[1]
    turned = own.reach * math.sqrt(dot(tilt, tilt)) + seen.clear_lever * math.sqrt(cos * cos + sin * sin)
    contacts = contacts_of(parameters, mode, w)
    left = seen.clear - (abs(seen.height - seen.clear_height) + turned)
    if left > 0.0 and contacts == seen.clear_contacts:
        return left
    seen.clear = least_gap_on_plane(parameters, mode, w, body)
    seen.clear_contacts, seen.clear_height = contacts, seen.height
    put(seen.clear_normal, vector(seen.normal, 0))
    seen.clear_turn[0], seen.clear_turn[1] = seen.cos, seen.sin
    seen.clear_lever = lever_of_spin(own, seen)
    return seen.clear


@kernel
def lever_of_spin(own, seen):
    """How far beside O, along the ground, a point of a wheel may be that is as high as the least gap, m. As the wheel
    turns by a, one d beside and l below O comes down by d sin(a) - l (1 - cos(a)), with d^2 + l^2 <= girth^2: of higher
    ones none comes lower than this."""
    below = seen.height - own.reach * abs(seen.normal[1]) - seen.clear
    return math.sqrt(max(own.girth * own.girth - max(below, 0.0) ** 2, 0.0))


@kernel
def contacts_of(parameters, mode, w):
    """A number for what touches of wheel w."""
    found = 0
    for c in range(mode.contacts):
        meeting = mode.roller[mode.slot[c]] * parameters.space.hubs[w].lobes + mode.meeting[c]
        found = found * MOST_MEETINGS + meeting + 1
    return found


@outlined
def least_gap_on_plane(parameters, mode, w, body):
    """The same on a plane. There a wheel is round enough: the next to touch is another lobe of a roller that does, its
    neighbour, or in the air that of the lowest place."""
    stand = standing_seen(parameters.space.stands[w], body)
    wheel, rows, lobes = parameters.wheels[w], parameters.space.hubs[w].row_count, parameters.space.hubs[w].lobes
    least = math.inf
    if mode.contacts == 0:
        lowest = lowest_roller(parameters, w, stand)
        for step in range(-rows, 2 * rows):
            for lobe in range(lobes):
                least = min(least, gap_at(parameters, w, stand, (lowest + step) % wheel.rollers, lobe))
        return least
    for c in range(mode.contacts):
        here = mode.roller[mode.slot[c]]
        for step in range(-rows, rows + 1):
            i = here + step
            i -= wheel.rollers if i >= wheel.rollers else 0
            i += wheel.rollers if i < 0 else 0
            for lobe in range(lobes):
                if not in_contact(mode, i, lobe):
                    least = min(least, gap_at(parameters, w, stand, i, lobe))
    return least


@outlined
def least_gap_on_ground(parameters, mode, w, body):
    """The same on uneven ground, of all rollers."""
    stand = standing_seen(parameters.space.stands[w], body)
    least = math.inf
    for meeting in range(meetings(parameters.space, w)):
        for i in range(parameters.wheels[w].rollers):
            if not in_contact(mode, i, meeting):
                least = min(least, gap_at(parameters, w, stand, i, meeting))
    return least


@outlined
def lowest_roller(parameters, w, stand):
    """The roller of the first row of wheel w that is next to the lowest place of the wheel, 0..N-1."""
    wheel, space = parameters.wheels[w], parameters.space
    rows = space.hubs[w].row_count
    first = roller_on(parameters, w, 0, stand)
    # azimuth of the lowest place less that of roller 0
    q_low = math.atan2(-stand.normal.x, stand.normal.z)
    q_0 = math.atan2(first.sin_q, first.cos_q)
    pitch = 2.0 * math.pi * rows / wheel.rollers
    return (round((q_low - q_0) / pitch) * rows) % wheel.rollers
