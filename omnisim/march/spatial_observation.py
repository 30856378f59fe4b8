"""The instants that a march of a machine free in space has recorded, looked at again."""

import math

from omnisim.base.kernel import kernel
from omnisim.base.vector import combine, cross, plus, times
from omnisim.dynamics.spatial.acceleration import hub_acceleration
from omnisim.dynamics.spatial.bearing_loads import recover_in_space
from omnisim.dynamics.spatial.energy import motion_energy, spring_energy, weight_energy
from omnisim.dynamics.spatial.pose import body_of, hub_of, mounted, outward, put, vector
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import joint_rate, roller_on, standing
from omnisim.dynamics.state import Stage, places
from omnisim.march.runge_kutta import evaluate

KINETIC, GRAVITY, ELASTIC = range(3)


@kernel
def observe_in_space(parameters, rows, times_, monitors, observed):
    """Evaluate every row."""
    at = places(parameters)
    for row in range(len(times_)):
        y, mode, slopes = rows.y[row], rows.mode[row], observed.slopes[row]
        evaluate(parameters, Stage(mode, rows.piece[row], times_[row], y, slopes, monitors, True))
        body = body_of(parameters, y)
        energies = observed.energies[row]
        energies[KINETIC] = motion_energy(parameters, y, rows.rates[row])
        energies[GRAVITY] = weight_energy(parameters, y)
        energies[ELASTIC] = spring_energy(parameters, mode, y)
        for w in range(len(parameters.wheels)):
            part = parameters.workspace.parts[w]
            seen = observed.wheels[row, w]
            seen.drive_torque, seen.voltage, seen.current = part.drive_torque, part.voltage, part.current
            observe_contacts(parameters, mode[w], w, body, y, seen)
            if len(observed.joint_rate):
                for i in range(parameters.wheels[w].rollers):
                    observe_roller(parameters, rows, row, w, i, body, observed)
            if len(observed.bearing_loads):
                loads = observed.bearing_loads[row, w]
                recover_in_space(parameters, mode[w], w, y, slopes, rows.rates[row, w], loads)
            if len(parameters.space.carriers) > 0:
                j = parameters.space.hubs[w].carrier
                seen.travel = y[at.joint + j] if j >= 0 else 0.0
                seen.travel_rate = y[at.joint_rate + j] if j >= 0 else 0.0


@kernel
def observe_contacts(parameters, mode, w, body, y, seen):
    """What is told of the contacts of wheel w: their load, and all else of the one that carries most."""
    found = -1
    most, total = -1.0, 0.0
    for c in range(mode.contacts):
        touch = parameters.space.touches[w * SLOTS + c]
        total += touch.normal_force
        if touch.normal_force > most:
            found, most = c, touch.normal_force
    seen.normal_force = total
    seen.roller, seen.share, seen.contact_torque, seen.angle = -1, 0.0, 0.0, 0.0
    hub = hub_of(parameters, body, w, y)
    centre = plus(body.position, outward(body.rotation, hub.centre))
    if found < 0:
        for i in range(2):
            seen.slip_velocity[i] = seen.friction_force[i] = 0.0
        put(seen.point, centre)
        return
    touch = parameters.space.touches[w * SLOTS + found]
    seen.roller = mode.roller[mode.slot[found]]
    seen.share = most / total if total > 0.0 else 1.0
    seen.contact_torque = touch.torque
    seen.angle = math.atan2(touch.azimuth[1], touch.azimuth[0])
    for i in range(2):
        seen.slip_velocity[i], seen.friction_force[i] = touch.slip[i], touch.force[i]
    put(seen.point, plus(centre, outward(body.rotation, outward(mounted(hub), vector(touch.point, 0)))))


@kernel
def observe_roller(parameters, rows, row, w, i, body, observed):
    """Joint rate of roller i of wheel w, and position, velocity and acceleration of its centre, world axes."""
    y, dy = rows.y[row], observed.slopes[row]
    at = places(parameters)
    stand = standing(parameters, w, body, y)
    hub, spin_rate = stand.hub, stand.spin_rate
    roller = roller_on(parameters, w, i, stand)
    observed.joint_rate[row, w, i] = joint_rate(stand, roller, rows.rates[row, w, i])
    axes = mounted(hub)
    arm = outward(axes, roller.centre)
    carried = outward(axes, hub.rate)
    rate = plus(carried, times(spin_rate, hub.k))
    lifted, turning = hub_acceleration(parameters, body, w, y, dy)
    turning = plus(turning, combine(dy[at.spin_rate + w], hub.k, spin_rate, cross(carried, hub.k), 0.0, arm))
    around = cross(rate, arm)
    position = plus(hub.centre, arm)
    velocity = plus(outward(axes, hub.velocity), around)
    acceleration = plus(lifted, plus(cross(turning, arm), cross(rate, around)))
    put(observed.motion[0, row, w, i], plus(body.position, outward(body.rotation, position)))
    put(observed.motion[1, row, w, i], outward(body.rotation, velocity))
    put(observed.motion[2, row, w, i], outward(body.rotation, acceleration))
