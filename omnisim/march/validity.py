"""Is what was computed still a motion? Checked at every grid point."""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import LOST_TRACK, NO_START, NOT_FINITE, RUNNING, TOO_STIFF, UNBALANCED
from omnisim.base.vector import dot
from omnisim.contact.frame import Axis, Slip
from omnisim.contact.friction import friction_factor
from omnisim.contact.mobility import inverse_mass, largest
from omnisim.contact.rolling_resistance import rolling_relaxation
from omnisim.contact.tracking import Contact, explicit_contact, roller_axis
from omnisim.dynamics.energy import kinetic_energy, potential_energy
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.spatial.energy import motion_energy, stored_energy
from omnisim.dynamics.spatial.mobility import contact_mobility
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.touching import standing, touching_at
from omnisim.dynamics.state import places
from omnisim.dynamics.wheel import on_row, rho_of

UNBALANCED_PART = 0.05  # of the energy of the scene
STILL = 1e-9  # m/s: slower than that moves what stands, in rounding; there is no energy to account for
STIFF_STEPS = 3  # surplus of steps too large for the rate at which slip relaxes, before the run stops
STATIONS = 32  # on half a roller, where its mobility is looked at
LOST = 1e-3  # |rho|^2 - 1 at which the implicit tracking is no longer worth its name


@kernel
def check(parameters, run):
    """Status of the state at a grid point: finite, and no slip relaxing faster than the method can follow.

    The friction force is bounded, so a step too large for it never overflows: slip chatters about zero with the
    amplitude that one step gives. It shows in steps outside the method's stability region that outnumber those
    inside; a slip that only passes through zero has one or two.
    """
    clock = run.clock
    if not finite(run.y, run.slopes[0]):
        clock.status = NOT_FINITE if clock.row else NO_START
        for w in range(len(run.mode)):
            if clock.stiff > 0 and clock.status != TOO_STIFF:
                too_stiff(parameters, run, w, clock.status)
        return
    stiff = -1
    for w in range(len(run.mode)):
        if parameters.space is None and parameters.machine.implicit_tracking:
            rho = rho_of(parameters, run.y, w, run.mode[w].index[0])
            if abs(dot(rho, rho) - 1.0) > LOST:
                clock.status, clock.wheel = LOST_TRACK, w
                return
        if too_fast(parameters, run, w):
            stiff = w
    clock.stiff = clock.stiff + 1 if stiff >= 0 else max(clock.stiff - 1, 0)
    if clock.stiff >= STIFF_STEPS:
        too_stiff(parameters, run, stiff, TOO_STIFF)


@kernel
def finite(y, dy):
    """Whether every state and every rate is, and the energy in it."""
    burst = False
    for m in range(len(y)):
        burst |= not y[m] * y[m] + dy[m] * dy[m] < math.inf
    return not burst


@kernel
def check_energy(parameters, run):
    """Stop a run of which a good part of the energy came from nowhere: its steps are too long, though none is stiff.

    Needs the rates of all rollers as they are now: at an output row.
    """
    machine = parameters.machine
    clock = run.clock
    y = run.y
    at = places(parameters)
    if parameters.space is not None:
        kinetic, potential = motion_energy(parameters, y, run.rates), stored_energy(parameters, run.mode, y)
    else:
        kinetic, potential = kinetic_energy(parameters, at, y, run.rates), potential_energy(machine, y)
    if clock.row == 0:
        clock.energy, clock.potential = kinetic, potential
    fall = clock.potential - potential  # work of the weight
    loss = y[at.friction_loss] + (y[at.bearing_loss] if machine.bearing_friction else 0.0)
    loss += y[at.rolling_loss] if machine.rolling else 0.0
    if parameters.space is not None:
        loss += y[at.contact_loss] + y[at.damper_loss]
    balance = kinetic - clock.energy + loss - y[at.drive_work] - y[at.wrench_work] - fall
    turned_over = clock.energy + abs(y[at.drive_work]) + abs(y[at.wrench_work]) + abs(fall)
    clock.turnover = max(clock.turnover, turned_over)  # the works may have come back to nothing
    missing = abs(balance) > UNBALANCED_PART * clock.turnover
    if missing and fastest(parameters, run) > STILL and clock.status == RUNNING:
        clock.status, clock.wheel = UNBALANCED, -1


@kernel
def fastest(parameters, run):
    """The largest speed at which anything moves: the body, or a wheel or a roller at its circumference, m/s."""
    y = run.y
    at = places(parameters)
    speed = max(abs(y[at.velocity]), abs(y[at.velocity + 1]))
    turning = abs(y[at.yaw_rate])
    for w in range(len(run.mode)):
        wheel = parameters.wheels[w]
        reach = abs(wheel.offset[0]) + abs(wheel.offset[1]) + wheel.radius
        speed = max(speed, reach * turning, wheel.radius * abs(y[at.spin_rate + w]))
        for i in range(wheel.rollers):
            speed = max(speed, (wheel.radius - wheel.roller_distance) * abs(run.rates[w, i]))
    return speed


@kernel
def too_fast(parameters, run, w):
    """Whether friction at wheel w relaxes slip faster than explicit steps can follow."""
    clock = run.clock
    machine = parameters.machine
    if parameters.workspace.resting is not None or run.newton is not None:
        return False
    for c in range(contact_count(run.mode[w])):
        if machine.rolling and run.monitors[w].relaxing[c] * clock.dt > clock.stability_limit:
            return True
        factor = run.monitors[w].factor[c]
        if factor * machine.slip_mobility * clock.dt > clock.stability_limit:  # the bound of the mobility is cheap
            return factor * mobility_at(parameters, run.mode[w], run.y, w, c) * clock.dt > clock.stability_limit
    return False


@outlined
def mobility_at(parameters, mode, y, w, c):
    """Largest eigenvalue of the inverse mass at contact c of wheel w, 1/kg: with the factor g, the rate of its slip."""
    if parameters.space is not None:
        stand = standing(parameters, w, body_of(parameters, y), y)
        return largest(contact_mobility(parameters, w, stand.hub, touching_at(parameters, mode, w, c, stand)))
    return slip_mobility(parameters, w)


@outlined
def too_stiff(parameters, run, w, otherwise):
    """Stop for friction at wheel w, with the largest rate at which it relaxes slip anywhere on a roller; with the
    status `otherwise` where steps could follow that, or where the load diverged and no rate is left."""
    clock = run.clock
    machine = parameters.machine
    load, still = run.monitors[w].normal_force, Slip(0.0, 0.0)
    at_rest = friction_factor(machine, 0, load, still, still)
    clock.rate = at_rest * roller_mobility(machine, parameters.wheels[w], parameters.roller_rows)
    if machine.rolling:
        clock.rate = max(clock.rate, load * rolling_relaxation(parameters.wheels[w], 0.0, 0.0))
    clock.status = otherwise
    if clock.stability_limit < clock.rate * clock.dt < math.inf or otherwise == TOO_STIFF:
        clock.status, clock.wheel = TOO_STIFF, w


@kernel
def roller_mobility(machine, wheel, rows):
    """Largest eigenvalue of the inverse mass of a wheel's contact anywhere on a roller, 1/kg; rows: of all wheels."""
    mobility = 0.0
    for i in range(-STATIONS, STATIONS + 1):
        cos_q, sin_q = math.cos(wheel.alpha * i / STATIONS), math.sin(wheel.alpha * i / STATIONS)
        axis, middle = roller_axis(wheel, cos_q, sin_q), explicit_contact(wheel, cos_q, sin_q)
        for r in range(wheel.row, wheel.row + wheel.rows):
            contact = on_row(middle, rows[r])
            mobility = max(mobility, largest(inverse_mass(machine, wheel, axis, contact)))
    return mobility


@kernel
def slip_mobility(parameters, w):
    """Largest eigenvalue of the inverse mass of wheel w's contact, 1/kg: with the factor g, the rate of its slip."""
    wheel = parameters.wheels[w]
    seen = parameters.workspace.contacts[wheel.contacts]
    axis = Axis(seen.axis[0], seen.axis[1], seen.axis[2])
    contact = Contact(seen.l, seen.arm[0], seen.arm[1])
    return largest(inverse_mass(parameters.machine, wheel, axis, contact))
