"""How the directions of slips turn that begin to creep: what the first step in them has to know (creeping.py)."""

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.set_valued import CREEP
from omnisim.march.creeping import creep_of, keep_creep, turned_by
from omnisim.march.runge_kutta import evaluate, refresh

MOMENT, ROUNDS = 1 / 32, 2  # of a step, after which it is seen how a direction turns, and how often


@outlined
def find_turning(parameters, run, t):
    """Find at which rates slips turn that begin to creep: by the directions a moment later, in rounds, as slip stays
    behind the direction from rest by as much as that turns while friction turns the slip."""
    moment = MOMENT * run.clock.dt
    for _ in range(ROUNDS):
        for m in range(len(run.y)):
            run.trial[m] = run.y[m] + moment * run.slopes[0, m]
        for w in range(len(run.mode)):
            keep_begun(parameters, run, w)
        evaluate(parameters, run.mode, run.clock.piece, t + moment, run.trial, run.slopes[-1], run.monitors_end)
        run.clock.rhs += 1
        for w in range(len(run.mode)):
            mode = run.mode[w]
            if begins(mode):
                later = creep_of(parameters, w, 0)
                mode.veering = turned_by(mode.creep[0], (later.h, later.k)) / moment
                mode.veer[0] = mode.veering
        refresh(parameters, run, t)
    for w in range(len(run.mode)):
        keep_begun(parameters, run, w)
        run.mode[w].foreseen = run.mode[w].foreseen or begins(run.mode[w])


@kernel
def begins(mode):
    """Whether a wheel has just begun to creep, or its slip is still young: its direction is not held yet."""
    return mode.grip[0] == CREEP and not mode.shared and mode.veer[1] == 0.0


@kernel
def keep_begun(parameters, run, w):
    if begins(run.mode[w]):
        keep_creep(parameters, run, w, 0)
