"""Where the joints hold the bodies: the closed kinematics from the joint coordinates to every body.

    chassis   r = C + c                                            w = theta' n
    disk      O = C + e_h h + e_k k,  R above the floor            w = theta' n + phi' k
    roller    O_B = O + R1 d,  axis a = c t + s k                  w = that of the disk + chi' a,  chi' = p - w . a

At the end of every step each body is put there (projection by coordinate partitioning: Wehage & Haug, ASME Journal of
Mechanical Design 104, 1982), so that constraints kept at the level of accelerations do not drift.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.contact.frame import Axis, axes, axis_vector, frame_on_chassis, turn_of
from omnisim.dynamics.indices import body_place, row_index
from omnisim.dynamics.multibody.joint_forces import mounting
from omnisim.dynamics.multibody.rigid_body import (
    Quaternion,
    RigidBody,
    product,
    rigid_body,
    square,
    store_quaternion,
    store_vector,
    third_axis,
    turned_to,
)
from omnisim.dynamics.state import BODY_STATES, YAW, X, Y, places
from omnisim.dynamics.twist import body_motion, world_frame
from omnisim.dynamics.wheel import azimuth_of


@kernel
def about_y(angle):
    """Rotation about the y axis by an angle, rad."""
    cos, sin = cos_sin(0.5 * angle)
    return Quaternion(cos, 0.0, sin, 0.0)


@kernel
def about_z(angle):
    cos, sin = cos_sin(0.5 * angle)
    return Quaternion(cos, 0.0, 0.0, sin)


@kernel
def length(a):
    return math.sqrt(dot(a, a))


@outlined
def project_bodies(parameters, run, counted):
    """Put every body of run.y where its joints hold it; if `counted`, how far it was from there enters the drift."""
    machine = parameters.machine
    wheels = parameters.wheels
    y = run.y
    at = places(parameters)
    body = body_motion(parameters, y)
    _, _, up = axes(body.frame)
    turning = times(body.twist.yaw, up)
    c = axis_vector(body.frame, Axis(machine.lever[0], machine.lever[1], machine.lever[2]))
    centre = Vec3(y[X], y[Y], machine.height)
    velocity = Vec3(y[at.velocity], y[at.velocity + 1], 0.0)
    chassis = RigidBody(plus(centre, c), about_z(y[YAW]), plus(velocity, cross(turning, c)), turning)
    drift = project_body(run, body_place(parameters, -1, 0), chassis, True)
    for w in range(len(wheels)):
        wheel = wheels[w]
        frame = world_frame(wheels[w], body)
        spin_angle, spin_rate = y[at.spin_angle + w], y[at.spin_rate + w]
        h, k, _ = axes(frame)
        e = plus(times(wheel.offset[0], h), times(wheel.offset[1], k))
        upright = about_z(y[YAW] + turn_of(frame_on_chassis(wheel)))
        disk = RigidBody(
            Vec3(y[X] + e.x, y[Y] + e.y, wheel.radius),
            product(upright, about_y(spin_angle)),
            plus(velocity, cross(turning, e)),
            plus(turning, times(spin_rate, k)),
        )
        drift = larger(drift, project_body(run, body_place(parameters, w, 0), disk, True))
        tilted = math.atan2(wheel.sin_psi, wheel.cos_psi) + math.pi
        tilt = Quaternion(math.cos(0.5 * tilted), math.sin(0.5 * tilted), 0.0, 0.0)
        for i in range(wheel.rollers):
            q = azimuth_of(parameters, w, i, spin_angle)
            d, _, axis = mounting(wheel, frame, q)
            rho = plus(times(wheel.roller_distance, d), times(parameters.roller_rows[row_index(wheel, i)].offset, k))
            place = body_place(parameters, w, i + 1)
            now = rigid_body(y, place).rotation
            rotation = product(upright, product(about_y(0.5 * math.pi - q), tilt))  # x along d
            if square(now) > 0.0:
                rotation = turned_to(now, axis)
            joint = y[wheel.rates + i] - dot(disk.rate, axis)
            roller = RigidBody(
                plus(disk.position, rho),
                rotation,
                plus(disk.velocity, cross(disk.rate, rho)),
                plus(disk.rate, times(joint, axis)),
            )
            drift = larger(drift, project_body(run, place, roller, False))
    if counted:
        y[at.drift], y[at.drift + 1] = max(y[at.drift], drift[0]), max(y[at.drift + 1], drift[1])


@kernel
def larger(a, b):
    return max(a[0], b[0]), max(a[1], b[1])


@kernel
def project_body(run, first, held, whole):
    """Put a body where it is held: how far it was from there (m or rad, m/s or rad/s).

    whole: all of its rotation is held, not its z axis alone. A body that has not been placed yet has no rotation.
    """
    y = run.y
    now = rigid_body(run.y, first)
    rotation = held.rotation
    gap = length(minus(now.position, held.position))
    turned = 0.0
    if whole:
        q = now.rotation
        along = q.w * rotation.w + q.x * rotation.x + q.y * rotation.y + q.z * rotation.z
        if along < 0.0:  # the same rotation, without a jump of the states
            rotation = Quaternion(-rotation.w, -rotation.x, -rotation.y, -rotation.z)
        left = q.w - abs(along) * rotation.w, q.x - abs(along) * rotation.x
        right = q.y - abs(along) * rotation.y, q.z - abs(along) * rotation.z
        turned = 2.0 * math.sqrt(left[0] ** 2 + left[1] ** 2 + right[0] ** 2 + right[1] ** 2)
    elif square(now.rotation) > 0.0:
        turned = length(cross(third_axis(now.rotation), third_axis(rotation)))
    speed = max(length(minus(now.velocity, held.velocity)), length(minus(now.rate, held.rate)))
    store_vector(y, first, held.position)
    store_quaternion(y, first, rotation)
    store_vector(y, first + 7, held.velocity)
    store_vector(y, first + 10, held.rate)
    for m in range(first, first + BODY_STATES):
        run.carry[m] = 0.0
    return max(gap, turned), speed
