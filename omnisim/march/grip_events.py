"""Events of set-valued friction: contacts let go, come to rest, and slip in a direction of their own."""

from omnisim.base.kernel import kernel
from omnisim.base.status import EVENT_KINDS
from omnisim.contact.set_valued import STICK
from omnisim.dynamics.indices import contact_count, roller_index, roller_of
from omnisim.march.event_log import record
from omnisim.march.friction_modes import come_to_rest, start_creep, start_slip

STUCK, SLIPS = EVENT_KINDS.index("stick"), EVENT_KINDS.index("slip")


@kernel
def change_grip(parameters, run, log, ends, w, side, time):
    """A contact lets go or comes to its end (`ends`: what it did has ended), or slips in a direction of its own."""
    mode = run.mode[w]
    if ends and mode.grip[side] == STICK:
        record_grip(parameters, run, log, time, SLIPS, w, told_roller(parameters, mode, w, side))
        start_creep(parameters, run, w, side, time)
    elif ends:
        end_slips(parameters, run, log, w, side, time)
    else:
        if mode.shared:
            record_grip(parameters, run, log, time, SLIPS, w, told_roller(parameters, mode, w, side))
        start_slip(parameters, run, w, side, time)


@kernel
def record_grip(parameters, run, log, time, kind, w, roller):
    """Append that a contact sticks or slips; with a layer in which it slips as well, none ever sticks."""
    if parameters.machine.slip_layer == 0.0:
        record(run.clock, log, time, kind, w, roller, -1)


@kernel
def told_roller(parameters, mode, w, side):
    """The roller of a contact where its wheel may have several, -1 where it is the only one."""
    if parameters.space is not None:
        return mode.roller[mode.slot[side]]
    return roller_index(parameters.wheels[w], roller_of(mode, side)) if mode.shared else -1


@kernel
def end_slips(parameters, run, log, w, side, time):
    """Slips that have come to their end, and that of contact `side` of wheel w (-1: of none): the contacts stick or
    creep on."""
    come_to_rest(parameters, run, w, side, True, time)
    for v in range(len(run.mode)):
        mode = run.mode[v]
        for other in range(contact_count(mode)):
            if mode.stopped[other]:
                record_grip(parameters, run, log, time, STUCK, v, told_roller(parameters, mode, v, other))
