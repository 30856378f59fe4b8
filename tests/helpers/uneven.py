"""Floors and rollers for tests of where they touch."""

import math

import numpy as np

from omnisim.base.records import records
from omnisim.base.vector import Vec3
from omnisim.contact.floor import floor_of
from omnisim.contact.patch import patch
from omnisim.contact.support import ARC, EXACT, SHAPE, region_of, support

NO_GRID = (np.zeros((0, 0)), (0.0, 0.0), (1.0, 1.0))


def floor(bumps=(), steps=(), grid=NO_GRID):
    return floor_of(np.array(bumps), np.array(steps), *grid)


def exact_roller(radius, distance, count, degrees):
    """The SHAPE of a roller of the exact profile, cut at pi / count."""
    alpha, cos = math.pi / count, math.cos(math.radians(degrees))
    drop, sine = radius - distance / math.cos(alpha), math.cos(math.radians(degrees)) * math.sin(alpha)
    half = distance * math.tan(alpha) / cos + drop * sine
    return shape(EXACT, radius, half, drop * math.sqrt(1.0 - sine * sine), sine, distance=distance, cos_psi=cos)


def barrel(radius, curvature_radius, half_length):
    """The SHAPE of a roller whose profile is an arc."""
    end = radius - curvature_radius + math.sqrt(curvature_radius**2 - half_length**2)
    return shape(ARC, radius, half_length, end, half_length / curvature_radius, curvature_radius=curvature_radius)


def shape(kind, radius, half_length, end_radius, end_tilt, *, distance=0.0, cos_psi=1.0, curvature_radius=0.0):
    values = (kind, radius, distance, cos_psi, curvature_radius, half_length, end_radius, end_tilt)
    return records(SHAPE, [dict(zip(SHAPE.names, values, strict=True))])[0]


def vec(array):
    return Vec3(*map(float, array))


def unit(array):
    return np.asarray(array, dtype=float) / np.linalg.norm(array)


def placed(ground, piece, at, roller, axis, depth):
    """Centre of a roller of this axis that touches a piece at these Coordinates to this depth (m); normal; region."""
    here = patch(ground, piece, at)
    nu = unit(np.cross(here.p, here.q))
    tilt = float(nu @ axis)
    up = nu - tilt * axis
    across = float(np.linalg.norm(up))
    region = region_of(roller, tilt)
    found = support(roller, region, tilt, across)
    return np.array(here.point) - depth * nu - found.u * axis + found.r * up / across, nu, region
