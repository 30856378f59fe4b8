"""Slip at the contacts of a state: its velocity, its rate, and how strongly friction draws it into one direction."""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.contact.kinematics import slip_acceleration
from omnisim.contact.mobility import across, inverse_mass
from omnisim.contact.set_valued import STICK
from omnisim.dynamics.indices import contact_count, rate_place
from omnisim.dynamics.spatial.acceleration import slip_at, slip_change
from omnisim.dynamics.spatial.holding import held_mobility
from omnisim.dynamics.spatial.mobility import contact_mobility
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.touching import standing, touching_at
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import acceleration_of, body_motion, wheel_motion
from omnisim.dynamics.wheel import contact_state
from omnisim.march.slip_bounds import STILL_STIFF, stiffness


class Course(NamedTuple):
    """How slip v goes on: v / |v|, |v| (m/s), its growth v . v' / |v| (m/s^2), the rate at which it turns (rad/s), that
    at which friction draws it into the direction of the contact equation (1/s), what it is across that direction by its
    turning (m/s; infinite where that does not attract), and the mass of the machine by that with which it resists a
    change of |v|."""

    h: float
    k: float
    speed: float
    growth: float
    turning: float
    attraction: float
    across: float
    lightness: float


@kernel
def slip_of(parameters, mode, w, side, y):
    """Slip velocity (Slip, m/s) at a contact of wheel w in state y."""
    if parameters.space is not None:
        return slip_at(parameters, mode, w, side, y)
    return contact_state(parameters, mode, w, side, body_motion(parameters, y), y).slip


@kernel
def slip_rate(parameters, mode, w, side, y, slope):
    """v' (Slip, m/s^2) at a contact of wheel w in a state y with this derivative, v (Slip, m/s), and A, 1/kg."""
    if parameters.space is not None:
        stand = standing(parameters, w, body_of(parameters, y), y)
        touched = touching_at(parameters, mode, w, side, stand)
        mobility = contact_mobility(parameters, w, stand.hub, touched)
        change = slip_change(parameters, mode, w, side, (stand, touched), y, slope)
        return change, slip_at(parameters, mode, w, side, y), mobility
    return upright_slip_rate(parameters, mode, w, side, y, slope)


@kernel
def upright_slip_rate(parameters, mode, w, side, y, slope):
    """The same of a machine that is upright."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    body = body_motion(parameters, y)
    state = contact_state(parameters, mode, w, side, body, y)
    acceleration = acceleration_of(parameters, body, slope)
    roller = slope[rate_place(parameters, mode, w, side)]
    motion = wheel_motion(wheel, body.twist, acceleration, slope[at.spin_rate + w], roller)
    mobility = inverse_mass(parameters.machine, wheel, state.axis, state.contact)
    return slip_acceleration(wheel, state, motion), state.slip, mobility


@kernel
def turning_mobility(parameters, run, w, side, mobility):
    """A of a contact of wheel w that friction turns with, 1/kg, of this A alone: in space without what others hold that
    stick, on the same wheel above all. Upright, that counts for little; and where friction turns slip more slowly than
    steps go, nobody asks."""
    if parameters.space is not None and parameters.workspace.resting is not None:
        stiff = stiffness(parameters, run.clock, run.monitors[w], side) > STILL_STIFF
        if stiff and any_sticks(run):
            return held_mobility(parameters, run.mode, run.y, w, side)
    return mobility


@kernel
def any_sticks(run):
    """Whether any contact is at rest."""
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if run.mode[w].grip[side] == STICK:
                return True
    return False


@kernel
def attraction(monitors, side, rate, slip, mobility):
    """Rate at which friction turns slip into the direction of the contact equation, by the square of slip, m^2/s^3."""
    along = slip.h * rate.h + slip.k * rate.k
    return monitors.factor[side] * across(mobility, slip.h, slip.k) + along


@kernel
def course_of(parameters, run, w, side):
    """The Course of the slip at a contact of wheel w."""
    monitors = run.monitors[w]
    rate, slip, mobility = slip_rate(parameters, run.mode[w], w, side, run.y, run.slopes[0])
    square = slip.h * slip.h + slip.k * slip.k
    speed = math.sqrt(square)
    along, turn = slip.h * rate.h + slip.k * rate.k, slip.h * rate.k - slip.k * rate.h
    attracted = attraction(monitors, side, rate, slip, turning_mobility(parameters, run, w, side, mobility))
    off = abs(turn) * speed / attracted if attracted > 0.0 else math.inf
    h, k = slip.h / speed, slip.k / speed
    lightness = parameters.machine.mass * across(mobility, -k, h)
    return Course(h, k, speed, along / speed, turn / square, attracted / square, off, lightness)
