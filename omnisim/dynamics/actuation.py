"""Drives at an instant: what each is asked for, what its limits leave of that, and the torque on its wheel.

    torque, rate   the demand is a torque, kept within +-limit
    follow         there is no demand: the table of angles gives the acceleration of the spin, and whatever torque that
                   takes is found once the contacts are known
    motor          the demand is a voltage, kept within K phi' +- R_a I_max, which holds the current, and then within
                   +-limit, which is all there is; drives.py has the motor's equations

With an inductance, a voltage kept so lets the current come near I_max at the pace R_a / L, and never beyond. A sampled
controller asks for the voltage that it found at its last sample; limits act at every instant.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.dynamics.parameters import DRIVE_INPUT
from omnisim.dynamics.state import places

FREE, BY_LIMIT, BY_CURRENT = range(3)  # which limit a drive is at; the sign is its sense
PLAY = 1e-12  # of a limit, between reaching and leaving it


@kernel
def drive_input(parameters, piece, t, w):
    """What the drive of wheel w is given: torque (N m), target rate (rad/s), voltage (V), phi'' to follow."""
    value, slope = parameters.inputs[piece, DRIVE_INPUT + w, 0], parameters.inputs[piece, DRIVE_INPUT + w, 1]
    return value + slope * (t - parameters.starts[piece])


@kernel
def followed(parameters, stage, w):
    """phi'' that a table of angles asks of wheel w, rad/s^2; 0 where the drive has none."""
    if parameters.machine.follows and parameters.wheels[w].follows:
        return drive_input(parameters, stage.piece, stage.t, w)
    return 0.0


@outlined
def follow_angles(parameters, stage, w, torque):
    """Turn wheel w as its table of angles says, if it has one: the power of its drive, W; its torque into the
    workspace.

    torque: the sum of all others on the axle, N m.
    """
    if not parameters.wheels[w].follows:
        return 0.0
    spin_rate = places(parameters).spin_rate + w
    acceleration = followed(parameters, stage, w)
    own = parameters.wheels[w].axle_inertia * acceleration - torque
    stage.dy[spin_rate] = acceleration
    parameters.workspace.parts[w].drive_torque = own
    return own * stage.y[spin_rate]


@kernel
def actuate(parameters, stage, w, spin_rate):
    """The drive of wheel w: its demand (N m or V) and tau on the disk about k (N m). Writes the rates of its states."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    mode = stage.mode[w]
    y = stage.y
    dy = stage.dy
    given_input = drive_input(parameters, stage.piece, stage.t, w)
    demand = wheel.drive_gain * given_input - wheel.drive_damping * y[at.spin_rate + w]
    if parameters.machine.integrals:
        demand += wheel.drive_integral * y[at.integral + w]
    if parameters.machine.motors and wheel.motor:
        if wheel.sample_steps > 0:
            demand = mode.held
        given, torque = turn_motor(parameters, mode.drive, w, demand, spin_rate, y, dy)
    else:
        given = torque = demand if mode.drive == FREE else mode.drive * wheel.drive_limit
    if parameters.machine.integrals:
        error = given_input - spin_rate
        dy[at.integral + w] = 0.0
        if wheel.drive_integral > 0.0 and wheel.sample_steps == 0:
            dy[at.integral + w] = unwound(wheel, error, demand, given)
    return demand, torque


@kernel
def unwound(wheel, error, demand, given):
    """Rate of the integrated error of a drive, rad/s: its error, and back from what limits cut off its demand."""
    return error if given == demand else error + (given - demand) / wheel.drive_gain


@outlined
def turn_motor(parameters, drive, w, demand, spin_rate, y, dy):
    """A motor that is asked for a voltage: what it gets (V) and its torque on the disk (N m).

    Writes the rates of its current and of the energies of motors; voltage and current into the workspace.
    """
    wheel = parameters.wheels[w]
    at = places(parameters)
    part = parameters.workspace.parts[w]
    back = wheel.motor_constant * spin_rate
    voltage = demand
    if abs(drive) == BY_LIMIT:
        voltage = drive * wheel.drive_limit
    elif abs(drive) == BY_CURRENT:
        voltage = back + (drive // BY_CURRENT) * wheel.resistance * wheel.current_limit
    if wheel.inductance > 0.0:
        current = y[at.current + w]
        dy[at.current + w] = (voltage - back - wheel.resistance * current) / wheel.inductance
    else:
        current = (voltage - back) / wheel.resistance
    rate = wheel.drive_friction_rate
    friction = wheel.drive_viscosity * spin_rate
    friction += wheel.drive_friction * spin_rate / math.sqrt(spin_rate * spin_rate + rate * rate)
    torque = wheel.motor_constant * current - friction
    dy[at.electrical] += voltage * current
    dy[at.heat] += wheel.resistance * current * current
    dy[at.motor_loss] += friction * spin_rate
    dy[at.motor_work] += torque * spin_rate
    part.voltage, part.current = voltage, current
    return voltage, torque


@kernel
def rest_motors(parameters, dy):
    """Rates of currents and of the energies of motors before any motor has added to them."""
    at = places(parameters)
    for m in range(at.current, at.friction_loss):
        dy[m] = 0.0
    dy[at.electrical] = dy[at.heat] = dy[at.motor_loss] = dy[at.motor_work] = 0.0


@kernel
def limit_guard(machine, wheel, drive, demand, spin_rate):
    """How far a drive is inside its limits, or beyond the one that it is at (N m or V); a little play between both."""
    if machine.motors and wheel.motor:
        return voltage_guard(wheel, drive, demand, spin_rate)
    if drive == FREE:
        return wheel.drive_limit - abs(demand)
    return drive * demand - wheel.drive_limit * (1.0 - PLAY)


@kernel
def next_limit(machine, wheel, drive, demand, spin_rate):
    """The limit at which a drive is after its guard has fired."""
    if machine.motors and wheel.motor:
        return next_voltage_limit(wheel, drive, demand, spin_rate)
    if drive != FREE:
        return FREE
    return BY_LIMIT if demand > 0.0 else -BY_LIMIT


@outlined
def voltage_guard(wheel, drive, demand, spin_rate):
    """The same for the voltage of a motor, V."""
    back = wheel.motor_constant * spin_rate
    most = wheel.drive_limit
    within = wheel.resistance * wheel.current_limit
    if drive == FREE:
        return min(min(back + within - demand, demand - back + within), min(most - demand, most + demand))
    sense = 1 if drive > 0 else -1
    if drive == sense * BY_LIMIT:
        return sense * min(max(demand, back - within), back + within) - most * (1.0 - PLAY)
    edge = back + sense * within
    return min(sense * (demand - edge) + PLAY * within, most * (1.0 + PLAY) - abs(edge))


@outlined
def next_voltage_limit(wheel, drive, demand, spin_rate):
    """The same for the voltage of a motor: the limit that is passed by most."""
    back = wheel.motor_constant * spin_rate
    most = wheel.drive_limit
    within = wheel.resistance * wheel.current_limit
    if drive == FREE:
        over_current = abs(demand - back) - within
        over_voltage = abs(demand) - most
        if over_current > over_voltage:
            return BY_CURRENT if demand > back else -BY_CURRENT
        return BY_LIMIT if demand > 0.0 else -BY_LIMIT
    sense = 1 if drive > 0 else -1
    if drive == sense * BY_LIMIT:
        if demand > back + within:
            return BY_CURRENT
        return -BY_CURRENT if demand < back - within else FREE
    edge = back + sense * within
    if sense * (demand - edge) <= most - abs(edge):
        return FREE
    return BY_LIMIT if edge > 0.0 else -BY_LIMIT


@outlined
def sample(parameters, mode, piece, t, w, y, again):
    """Let the controller of wheel w read the spin rate at time t, and hold a voltage until its next sample.

        V_n = K_p e_n + K_i z_n - K_d (phi'_n - phi'_n-1) / T
        z_n+1 = z_n + T (e_n + (V_n within its limits - V_n) / K_p)

    again: at the instant of the last sample, since its input has changed.
    """
    wheel = parameters.wheels[w]
    rate = y[places(parameters).spin_rate + w]
    if not again:
        mode.integral += wheel.sample_time * mode.winding
        mode.past_rate = mode.read_rate if t > 0.0 else rate
        mode.read_rate = rate
    error = drive_input(parameters, piece, t, w) - rate
    mode.held = wheel.drive_gain * error + wheel.drive_integral * mode.integral
    mode.held -= wheel.drive_derivative * (rate - mode.past_rate) / wheel.sample_time
    back = wheel.motor_constant * rate
    most = wheel.drive_limit
    within = wheel.resistance * wheel.current_limit
    given = min(max(min(max(mode.held, back - within), back + within), -most), most)
    mode.winding = unwound(wheel, error, mode.held, given)
