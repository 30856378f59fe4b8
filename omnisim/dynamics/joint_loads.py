"""Where the load of a joint goes: into a row of output as it is, or into extremes of the march.

One kernel enters it either way, by the shape of what it is entered into, which is known when it is compiled. Axes are
fixed in what carries the joint (dynamics/bearing_loads.py).
"""

from omnisim.base.kernel import kernel

AXIAL, ROLLER_AXIAL = 1, 2  # which direction is along the bearing, of an axle and of a roller
RADIAL_SQUARE, LEAST_AXIAL, MOST_AXIAL, TILTING_SQUARE = range(4)


@kernel
def enter(found, joint, axial, wrench):
    """The Wrench3 of a joint, whose bearing is along the direction `axial`, into found: (2, 3, N + 1) force, N, and
    moment, N m, of every joint; or (4, N + 1) the largest square of the force across and the least and the most along
    it, N, and the largest square of the tilting moment, N m, widened by these."""
    force, moment = wrench.force, wrench.moment
    if found.ndim == 3:
        found[0, 0, joint], found[0, 1, joint], found[0, 2, joint] = force.x, force.y, force.z
        found[1, 0, joint], found[1, 1, joint], found[1, 2, joint] = moment.x, moment.y, moment.z
    else:
        along = force.z if axial == ROLLER_AXIAL else force.y
        found[RADIAL_SQUARE, joint] = anew(max(found[RADIAL_SQUARE, joint], across_square(force, axial)))
        found[TILTING_SQUARE, joint] = anew(max(found[TILTING_SQUARE, joint], across_square(moment, axial)))
        found[LEAST_AXIAL, joint] = anew(min(found[LEAST_AXIAL, joint], along))
        found[MOST_AXIAL, joint] = anew(max(found[MOST_AXIAL, joint], along))


@kernel
def anew(value):
    """The same number, and no longer the one that was there: LLVM would store only where it changes, under a mask, for
    which AMD processors take longer than for all the rest of a load."""
    return value + 0.0


@kernel
def across_square(vector, axial):
    """Square of what a vector has across the direction `axial`."""
    return vector.x * vector.x + (vector.y * vector.y if axial == ROLLER_AXIAL else vector.z * vector.z)
