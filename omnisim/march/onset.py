"""The modes at t = 0: which rollers carry the wheels, and what sticks, found for all wheels together.

A wheel that turns takes its roller by the sense of its spin. One at rest on an edge could stand on the roller ahead,
on the one behind, or on both; which of them hold, the acceleration tells, and that depends on all the other wheels.
So every wheel begins on one roller, and as long as some wheel does not hold on to what it has, it goes further:

    roller ahead, phi'' >= 0   <->   roller behind, phi'' <= 0   ->   both, each pushes back   ->   one of them

Where each roller alone would roll away from the edge, both motions are admissible. The wheel begins where it would be
turned without friction, as any smooth law does, whose friction grows from nothing; else ahead. There it stays.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import RUNNING
from omnisim.contact.friction import SATURATED
from omnisim.contact.set_valued import SLIP
from omnisim.dynamics.indices import contact_count, roller_index, roller_of
from omnisim.dynamics.state import places
from omnisim.march.event_log import record
from omnisim.march.events import SHARED, restore_consistency
from omnisim.march.friction_modes import come_to_rest
from omnisim.march.roller_exchange import (
    edge_rounding,
    edge_torque,
    edge_torque_of,
    leave_edge,
    release_rollers,
    rest_on_both,
    take_rollers,
    touching,
)
from omnisim.march.runge_kutta import refresh

MOST_CHANGES = 50  # of rollers, before the march goes on with those that there are


@outlined
def stand(parameters, run, log):
    """The mode of every wheel at t = 0, and the derivative."""
    take_first(parameters, run)
    find_friction(parameters, run, log)
    for _ in range(MOST_CHANGES):
        changed = False
        for w in range(len(run.mode)):
            changed = goes_further(parameters, run, log, w) or changed
        if not changed:
            return


@kernel
def take_first(parameters, run):
    """Rollers as the spin tells, and of a wheel at rest on an edge as it would be turned without friction."""
    at = places(parameters)
    for w in range(len(run.mode)):
        mode = run.mode[w]
        ahead, behind = touching(parameters, w, run.y)
        mode.direction = -1 if run.y[at.spin_rate + w] < 0.0 else 1
        mode.loaded = 1
        take_rollers(parameters, run, w, behind if mode.direction < 0 else ahead, False)
    refresh(parameters, run, 0.0)
    for w in range(len(run.mode)):
        mode, monitors = run.mode[w], run.monitors[w]
        turned = edge_torque_of(parameters, mode, w, run.slopes[0], monitors)
        if on_edge(parameters, run, w) and turned < -edge_rounding(parameters, mode, w, run.y, monitors):
            mode.direction = -1
            take_rollers(parameters, run, w, mode.roller - 1, False)


@kernel
def on_edge(parameters, run, w):
    """Whether wheel w is at rest where two rollers touch."""
    ahead, behind = touching(parameters, w, run.y)
    return ahead != behind and run.y[places(parameters).spin_rate + w] == 0.0


@outlined
def find_friction(parameters, run, log):
    """What sticks, is loaded and at its limit with the rollers as they are, all of it anew, and the events of that."""
    clock = run.clock
    slip_speed = parameters.machine.slip_speed
    clock.events, clock.status, clock.wheel = 0, RUNNING, -1
    for w in range(len(run.mode)):
        mode, wheel = run.mode[w], parameters.wheels[w]
        mode.loaded, mode.drive = 1, 0
        mode.grip[0] = mode.grip[1] = SLIP
        if mode.shared:
            record(
                clock, log, 0.0, SHARED, w, roller_index(wheel, mode.roller), roller_index(wheel, roller_of(mode, 1))
            )
    refresh(parameters, run, 0.0)
    if parameters.workspace.resting is not None:
        come_to_rest(parameters, run, -1, 0, True, 0.0)
    elif parameters.machine.law == SATURATED:
        for w in range(len(run.mode)):
            for side in range(contact_count(run.mode[w])):
                fast = run.monitors[w].slip_square[side] > slip_speed * slip_speed
                run.mode[w].saturated[side] = fast
        refresh(parameters, run, 0.0)
    restore_consistency(parameters, run, log, 0.0)


@outlined
def goes_further(parameters, run, log, w):
    """Whether wheel w at rest on an edge does not hold on to what carries it there; then something else does."""
    if not on_edge(parameters, run, w):
        return False
    mode = run.mode[w]
    if edge_torque(parameters, run, w, 0.0) >= 0.0:
        refresh(parameters, run, 0.0)  # it may have looked at a later moment
        return False
    if mode.shared:
        leave_edge(parameters, run, w, 0.0)
    else:
        release_rollers(parameters, run, w)
        mode.direction = -mode.direction
        take_rollers(parameters, run, w, mode.roller + mode.direction, False)
        find_friction(parameters, run, log)
        if edge_torque(parameters, run, w, 0.0) >= 0.0:
            return True
        release_rollers(parameters, run, w)
        rest_on_both(parameters, run, w, mode.roller if mode.direction > 0 else mode.roller + 1, 0.0)
    find_friction(parameters, run, log)
    return True
