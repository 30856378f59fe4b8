"""The right-hand side y' = f(t, y): the three contact stages for every wheel, then Newton and Euler.

    M V' = sum F + f                                                           F = (F_h, F_k) on the roller
    Ia p' = arm . F + M_n (a . n) + T                                          M_n contact torque, T bearing torque
    (J_k + J_r) phi'' + sum Ia p' s + theta' G_h = tau - R F_h                 G = sum Ia p_i a_i, all rollers
    I_z theta'' = sum (lever . F + M_n (1 - (a . n)^2) + phi' G_h) + yaw torque

Friction of a sliding wheel is known but for its load (`slide_wheel`); what other wheels find at their contacts waits in
the workspace (`observe_wheel`). Then loads and forces are found together (planar_body.py, normal_forces,
contact_forces.py), and each wheel takes its share (`press_wheel`, `move_wheel`).
"""

import math

from omnisim.base.kernel import kernel
from omnisim.base.trigonometry import cos_sin
from omnisim.contact.tracking import rho_rate, roller_axis
from omnisim.dynamics.actuation import rest_motors
from omnisim.dynamics.contact_forces import find_forces
from omnisim.dynamics.indices import rho_place
from omnisim.dynamics.multibody.right_hand_side import multibody_rhs
from omnisim.dynamics.normal_forces.solution import given_load, loads_known, loads_sought
from omnisim.dynamics.normal_forces.tilt import set_body_tilt
from omnisim.dynamics.planar_body import free_equations, inclined_equations
from omnisim.dynamics.sliding_wheel import press_wheel, slide_wheel, slides_alone
from omnisim.dynamics.spatial.right_hand_side import spatial_rhs
from omnisim.dynamics.state import YAW, X, Y, places
from omnisim.dynamics.twist import Acceleration, body_motion, in_world, power_of, wheel_twist, world_frame
from omnisim.dynamics.wheel import external_wrench, rho_of
from omnisim.dynamics.wheel_forces import move_wheel, observe_wheel


@kernel
def rhs(parameters, stage):
    """Write y' of a Stage; if it is `monitoring`, also what the events need to know of each wheel and, into the
    workspace, what else is of interest: inside a step nobody looks at them.
    """
    if parameters.space is not None:
        spatial_rhs(parameters, stage)
    elif parameters.workspace.articulated is not None:
        multibody_rhs(parameters, stage)
    else:
        reduced_rhs(parameters, stage)
    if parameters.machine.odometry:
        odometry_rates(parameters, stage.y, stage.dy)
    if parameters.space is None and parameters.machine.implicit_tracking:
        rho_rates(parameters, body_motion(parameters, stage.y), stage.y, stage.dy)


@kernel
def reduced_rhs(parameters, stage):
    """The same of the reduced formulation, without odometry and rho."""
    machine = parameters.machine
    wheels = parameters.wheels
    workspace = parameters.workspace
    at = places(parameters)
    mode, y, dy = stage.mode, stage.y, stage.dy
    # Rates of positions first: the sine and cosine of the next stage can then start while the forces are computed.
    dy[X], dy[Y], dy[YAW] = y[at.velocity], y[at.velocity + 1], y[at.yaw_rate]
    body = body_motion(parameters, y)
    wrench = external_wrench(parameters, stage.piece, stage.t, body)
    known = loads_known(machine)
    weighing = loads_sought(parameters, stage)
    if weighing:
        set_body_tilt(machine, workspace.loads, wrench, body.twist.yaw)
    load = machine.mass * machine.gravity - wrench.z
    others = 0
    sought = 0
    equations = free_equations(machine, wrench.x, wrench.y, wrench.yaw)
    if machine.inclined:
        equations = inclined_equations(machine, body, equations)
    heat, power = 0.0, 0.0  # of friction and of the drives, W
    if machine.bearing_friction:
        dy[at.bearing_loss] = 0.0
    if machine.rolling:
        dy[at.rolling_loss] = 0.0
    if machine.motors:
        rest_motors(parameters, dy)
    share = given_load(machine, load, len(wheels))
    for w in range(len(wheels)):
        part = workspace.parts[w]
        part.slides = slides_alone(machine, mode[w])
        if part.slides:
            part.sought = 0  # it may have crept before
            equations, loss, work = slide_wheel(parameters, stage, w, body, share, equations)
            heat, power = heat + loss, power + work
        else:
            others += 1
    pushing = known or machine.viscous == 1  # some contact, without waiting for its load
    if others:
        for w in range(len(wheels)):
            part = workspace.parts[w]
            if not part.slides:
                equations, work = observe_wheel(parameters, stage, w, body, share, equations, weighing)
                power = power + work
                sought = sought + part.sought
                pushing = pushing or mode[w].shared == 1
    if others or not known:
        acceleration, regular = find_forces(parameters, load, equations, weighing, pushing, sought)
        for w in range(len(wheels)):
            if stage.monitoring:
                stage.monitors[w].regular = regular
            if not workspace.parts[w].slides:
                loss, work = move_wheel(parameters, stage, w, acceleration)
                heat, power = heat + loss, power + work
            elif not known:
                loss, work = press_wheel(parameters, stage, w)
                heat, power = heat + loss, power + work
    else:
        mobility = machine.mobility
        acceleration = Acceleration(
            equations.x * mobility, equations.y * mobility, equations.yaw * machine.yaw_mobility
        )
    dy[at.friction_loss], dy[at.drive_work] = heat, power
    linear = in_world(body, acceleration)
    dy[at.velocity], dy[at.velocity + 1], dy[at.yaw_rate] = linear.x, linear.y, acceleration.yaw
    dy[at.wrench_work] = power_of(wrench, body.twist)


@kernel
def odometry_rates(parameters, y, dy):
    """Velocity of the chassis origin as the ideal wheels tell it, in a world that their own yaw tells."""
    at = places(parameters)
    yaw = parameters.machine.odometry_yaw
    x_rate = 0.0
    y_rate = 0.0
    for w in range(len(parameters.wheels)):
        twist = parameters.wheels[w].odometry
        yaw += twist[2] * y[at.spin_angle + w]
        x_rate += twist[0] * y[at.spin_rate + w]
        y_rate += twist[1] * y[at.spin_rate + w]
    cos, sin = cos_sin(yaw)
    dy[at.odometry], dy[at.odometry + 1] = x_rate * cos - y_rate * sin, x_rate * sin + y_rate * cos


@kernel
def rho_rates(parameters, body, y, dy):
    """rho' of every roller: the implicit tracking integrates it for those in the air as well."""
    at = places(parameters)
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        frame = world_frame(wheel, body)
        twist = wheel_twist(wheel, body.twist, y[at.spin_rate + w])
        angle = wheel.phase - y[at.spin_angle + w]
        cos_0, sin_0 = math.cos(angle), math.sin(angle)
        for i in range(wheel.rollers):
            cos_i, sin_i = parameters.sector[w, 0, i], parameters.sector[w, 1, i]
            axis = roller_axis(wheel, cos_0 * cos_i - sin_0 * sin_i, sin_0 * cos_i + cos_0 * sin_i)
            rate = rho_rate(frame, axis, twist, rho_of(parameters, y, w, i))
            j = rho_place(parameters, w, i)
            dy[j], dy[j + 1], dy[j + 2] = rate.x, rate.y, rate.z
