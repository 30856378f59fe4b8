"""Slip within a thin layer: the saturated law, where friction relaxes slip within far less than a step.

Up to slip_speed eps that law is F = -mu N v / eps, and slip relaxes at the rate mu N A / eps to

    v = -eps F / (mu N)        with F for which v' = b + A F is the rate of this

Where a step is many times that long, it has relaxed at once: friction is the set-valued law of Coulomb, of which a
contact that sticks slips by this v, and lets go at |F| = mu N, |v| = eps. Its rate is that over the last step; what
that errs by is taken away at the end of the next one by an impulse, as friction would have done.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.set_valued import STICK, TINY
from omnisim.dynamics.impulses import align_slip
from omnisim.march.runge_kutta import refresh

TELLING = 0.1  # of a step: in less, slip may not have relaxed, and its change tells no rate


@kernel
def layered(mode):
    """Whether a wheel slips within the layer."""
    return mode.grip[0] == STICK and not mode.shared


@kernel
def any_layered(parameters, run):
    """Whether any wheel does."""
    found = False
    if parameters.machine.slip_layer > 0.0:
        for w in range(len(run.mode)):
            found = found or layered(run.mode[w])
    return found


@kernel
def relaxed_slip(parameters, w):
    """Slip (h, k) to which friction relaxes that of wheel w by the forces of the last right-hand side, m/s."""
    machine, part = parameters.machine, parameters.workspace.parts[w]
    force = parameters.workspace.contacts[part.first].force
    size = math.sqrt(force[0] * force[0] + force[1] * force[1])  # at the edge of the cone in rounding
    by_force = machine.slip_layer / max(machine.friction * part.normal_force, size, TINY)
    return -by_force * force[0], -by_force * force[1]


@kernel
def follow_layer(parameters, run, h):
    """Slips within the layer at the end of a step h, and the rates at which they change."""
    telling = TELLING * run.clock.dt
    for w in range(len(run.mode)):
        mode = run.mode[w]
        if layered(mode):
            slip_h, slip_k = relaxed_slip(parameters, w)
            mode.layer[0], mode.layer[1] = slip_h, slip_k
            known, mode.since = mode.since >= 0.0, mode.since + h
            if known and mode.since > telling:
                mode.easing[0] = (slip_h - mode.eased[0]) / mode.since
                mode.easing[1] = (slip_k - mode.eased[1]) / mode.since
            if not known or mode.since > telling:
                mode.eased[0], mode.eased[1], mode.since = slip_h, slip_k, 0.0


@outlined
def relax_slips(parameters, run, t):
    """Forces have jumped, or a contact has come to rest: slips within the layer relax at once."""
    for w in range(len(run.mode)):
        forget_rate(run.mode[w])
    refresh(parameters, run, t)
    follow_layer(parameters, run, 0.0)
    align_slip(parameters, run, False)
    refresh(parameters, run, t)


@kernel
def forget_rate(mode):
    """Nothing tells any more how slip within the layer changes."""
    mode.since = -1.0
    mode.easing[0] = mode.easing[1] = 0.0


@kernel
def enter_layer(mode):
    """Slip of a wheel has come to its end, and not relaxed yet."""
    forget_rate(mode)
    mode.layer[0] = mode.layer[1] = 0.0
