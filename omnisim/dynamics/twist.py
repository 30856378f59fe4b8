"""The machine as one upright body: where it points, its twist, and what that is for a wheel and for the state.

Its axes x, y, z are those of the chassis, at the common centre of mass C; z is the floor's normal. It turns about z
alone, so its axes are a Frame like those of its wheels.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec2
from omnisim.contact.frame import Frame, Motion, Slip, WheelTwist, frame_by, frame_on_chassis, outward, tangential
from omnisim.dynamics.state import YAW, places


class Twist(NamedTuple):
    """Velocity of C along the axes of the machine (m/s), and its yaw rate (rad/s)."""

    x: float
    y: float
    yaw: float


class Acceleration(NamedTuple):
    """Of C along the axes of the machine (m/s^2), and of the yaw (rad/s^2)."""

    x: float
    y: float
    yaw: float


class Wrench(NamedTuple):
    """External force (axes of the machine, N) and its torque about the vertical through C (N m)."""

    x: float
    y: float
    z: float
    yaw: float


class Body(NamedTuple):
    """The axes of the machine in the world, and its motion along them."""

    frame: Frame
    twist: Twist


@kernel
def body_motion(parameters, y):
    """The Body in state y."""
    at = places(parameters)
    cos, sin = cos_sin(y[YAW])
    frame = Frame(cos, sin)
    velocity = tangential(frame, Vec2(y[at.velocity], y[at.velocity + 1]))
    return Body(frame, Twist(velocity.h, velocity.k, y[at.yaw_rate]))


@kernel
def world_frame(wheel, body):
    """The Frame of a wheel in the world."""
    return frame_by(body.frame, frame_on_chassis(wheel))


@kernel
def wheel_twist(wheel, twist, spin_rate):
    """The WheelTwist of a wheel of a machine with this Twist."""
    carried = tangential(frame_on_chassis(wheel), twist)
    ahead, aside = wheel.offset[0], wheel.offset[1]
    return WheelTwist(carried.h - twist.yaw * aside, carried.k + twist.yaw * ahead, spin_rate, twist.yaw)


@kernel
def wheel_motion(wheel, twist, acceleration, spin, roller):
    """The Motion of a wheel from the Acceleration of its machine, and those of its spin and its roller, rad/s^2."""
    carried = tangential(frame_on_chassis(wheel), acceleration)
    turning = twist.yaw * twist.yaw
    ahead, aside = wheel.offset[0], wheel.offset[1]
    return Motion(
        carried.h - acceleration.yaw * aside - turning * ahead,
        carried.k + acceleration.yaw * ahead - turning * aside,
        spin,
        acceleration.yaw,
        roller,
    )


@kernel
def acceleration_of(parameters, body, dy):
    """The Acceleration of a Body, from the derivative of its state."""
    at = places(parameters)
    linear = tangential(body.frame, Vec2(dy[at.velocity], dy[at.velocity + 1]))
    return Acceleration(linear.h, linear.k, dy[at.yaw_rate])


@kernel
def in_world(body, acceleration):
    """The acceleration of C along the axes of the world (Vec2), from the Acceleration of a Body."""
    return outward(body.frame, Slip(acceleration.x, acceleration.y))


@kernel
def power_of(wrench, twist):
    """Of a wrench on a machine, W."""
    return wrench.x * twist.x + wrench.y * twist.y + wrench.yaw * twist.yaw
