"""Vectors of three floats as named tuples: in compiled code they cost nothing, unlike small arrays."""

from typing import NamedTuple

from omnisim.base.kernel import kernel


class Vec3(NamedTuple):
    """World components x, y, z."""

    x: float
    y: float
    z: float


class Vec2(NamedTuple):
    """Components x, y of a vector along the floor."""

    x: float
    y: float


@kernel
def plus(a, b):
    return Vec3(a.x + b.x, a.y + b.y, a.z + b.z)


@kernel
def minus(a, b):
    return Vec3(a.x - b.x, a.y - b.y, a.z - b.z)


@kernel
def times(factor, a):
    return Vec3(factor * a.x, factor * a.y, factor * a.z)


@kernel
def dot(a, b):
    return a.x * b.x + a.y * b.y + a.z * b.z


@kernel
def cross(a, b):
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@kernel
def combine(alpha, a, beta, b, gamma, c):
    """alpha a + beta b + gamma c."""
    return Vec3(
        alpha * a.x + beta * b.x + gamma * c.x,
        alpha * a.y + beta * b.y + gamma * c.y,
        alpha * a.z + beta * b.z + gamma * c.z,
    )
