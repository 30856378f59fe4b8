"""Floors and rollers for tests of where they touch."""

import math

import numpy as np

from omnisim.base.vector import Vec3
from omnisim.contact.floor import floor_of
from omnisim.contact.patch import patch
from omnisim.contact.support import SHAPE, region_of, support
from omnisim.dynamics.spatial.packing import array_of, shape_values
from omnisim.scene.ground_schema import Profile
from omnisim.scene.wheel_schema import Disk, Roller, WheelType

BEHIND, WITHIN, AHEAD = range(3)  # regions of a profile between two edges
NO_GRID = (np.zeros((0, 0)), (0.0, 0.0), (1.0, 1.0))


def floor(bumps=(), steps=(), grid=NO_GRID):
    return floor_of(np.array(bumps), np.array(steps), *grid)


def exact_roller(radius, distance, count, degrees):
    """The SHAPE of a roller of the exact profile, cut at pi / count."""
    scene = kind(radius=radius, roller_distance=distance, roller_count=count, roller_angle_deg=degrees)
    return shapes(scene)[0]


def barrel(radius, curvature_radius, half_length):
    """The SHAPE of a roller whose profile is an arc."""
    arc = Profile(kind="arc", radius=radius, curvature_radius=curvature_radius, half_length=half_length)
    return rollers(arc)[0]


def rollers(profile):
    """The SHAPE records of a roller of this profile: of its lobes."""
    return shapes(kind(profile=profile))


def kind(**keys):
    """A WheelType of which only these keys matter."""
    given = {"radius": 0.1, "roller_distance": 0.08, "roller_count": 6, "roller_angle_deg": 0.0, "roller": Roller()}
    return WheelType(**(given | keys), disk=Disk(mass=1.0))


def shapes(wheel_type):
    values = {"cos_psi": math.cos(math.radians(wheel_type.roller_angle_deg))}
    return array_of(SHAPE, shape_values(wheel_type, values))


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
