"""What happens to all machines between two control intervals, compiled: inputs for their drives, observations of them.

As NumPy has it, a few µs for each of some sixty operations, it would take longer than to march machines by long steps.
"""

import math

from omnisim.base.kernel import kernel
from omnisim.dynamics.parameters import DRIVE_INPUT
from omnisim.dynamics.state import YAW

ERROR, TARGET_RATE, TWIST, SPIN_RATES = 0, 3, 6, 9  # where they begin in an observation


@kernel
def drive_each(who, wheels, values, clocks, starts, inputs):
    """Give the drives of these wheels (D,), of each of the machines `who` (N,), booleans, their inputs (N, D) from now
    on: the piece of the tables starts and inputs that one from outside begins."""
    for i in range(len(who)):
        if who[i]:
            clock = clocks[i]
            clock.piece = 0
            starts[i, 1] = clock.step * clock.dt
            for d in range(len(wheels)):
                inputs[i, 1, DRIVE_INPUT + wheels[d], 0] = values[i, d]


@kernel
def observe_each(states, places, records, path, steps, loads, observed):
    """Observations (N, O) of machines as they are: see follow.py. Of one that is no longer finite zeros.

    states: (N, n); places: where velocity, yaw rate and spin rates begin in one. records: machines (N,), modes and
    monitors (N, W). path: a Path, of which each machine has gone so many steps (N,).
    """
    velocity, yaw_rate, spin_rate = places
    machines, modes, monitors = records
    poses, rates = path.poses, path.rates
    wheels = modes.shape[1]
    later = SPIN_RATES + wheels * (2 if loads else 1)
    for i in range(len(states)):
        y, found, step = states[i], observed[i], steps[i]
        yaw, turning, centre = y[YAW], y[yaw_rate], machines[i].centre
        axes = math.cos(yaw), math.sin(yaw)
        c_x, c_y = axes[0] * centre[0] - axes[1] * centre[1], axes[1] * centre[0] + axes[0] * centre[1]
        x, y_, v_x, v_y = y[0] - c_x, y[1] - c_y, y[velocity] + turning * c_y, y[velocity + 1] - turning * c_x
        for j in range(poses.shape[1]):
            target = poses[step, j]
            turn = (target[YAW] - yaw + math.pi) % (2.0 * math.pi) - math.pi
            put(found, ERROR if j == 0 else later + 3 * (j - 1), axes, target[0] - x, target[1] - y_, turn)
        put(found, TARGET_RATE, axes, rates[step, 0], rates[step, 1], rates[step, 2])
        put(found, TWIST, axes, v_x, v_y, turning)
        for w in range(wheels):
            found[SPIN_RATES + w] = y[spin_rate + w]
            if loads:
                carried = monitors[i, w].normal_force if modes[i, w].loaded else 0.0
                found[SPIN_RATES + wheels + w] = max(carried, 0.0)
        if not math.isfinite(found.sum()):
            found[:] = 0.0


@kernel
def put(found, place, axes, x, y, turn):
    """A vector of world axes into those of a machine, and a turn."""
    cos, sin = axes
    found[place], found[place + 1], found[place + 2] = cos * x + sin * y, cos * y - sin * x, turn
