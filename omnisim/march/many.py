"""Many machines in one call: their arrays stand along a first axis, and each is cut out of them as a run of its own.

What is cut out has the types of one run, so all kernels of `march` are those of one run too. Rows and events are kept
of none: one Recording and one log serve all, one after the other.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import LOG_FULL
from omnisim.dynamics.parameters import Parameters, Workspace
from omnisim.dynamics.state import Newton, Run
from omnisim.march.march import march


@kernel
def march_each(many, method, runs, rows, log, first, last):
    """March the machines from `first` up to but without `last`, each to its own goal.

    many, runs: Parameters and Run with a first axis of machines. rows (2 rows), log: of one run. What is cut out is
    put together here, since no kernel can return records.
    """
    for i in range(first, last):
        w, n = many.workspace, runs.newton
        resting = None if many.workspace.resting is None else w.resting[i]
        bodies = None if many.workspace.articulated is None else w.articulated[i]
        joints = None if many.workspace.joints is None else w.joints[i]
        newton = None
        if runs.newton is not None:
            matrices = n.stages[i], n.real[i], n.complex[i], n.pivots[i]
            newton = Newton(n.active[i], n.busy[i], *matrices, n.sought[i])
        workspace = Workspace(w.contacts[i], w.parts[i], w.loads[i], resting, bodies, joints, w.beside[i])
        geometry = many.machine[i], many.wheels[i], many.roller_rows[i], many.sector[i]
        parameters = Parameters(*geometry, many.starts[i], many.inputs[i], workspace, None)  # upright, all of them
        vectors = runs.y[i], runs.trial[i], runs.carry[i], runs.increment[i], runs.slopes[i]
        records = runs.mode[i], runs.monitors[i], runs.monitors_end[i], runs.clock[i]
        march_on(parameters, method, Run(*vectors, runs.rates[i], *records, newton), rows, log)


@outlined
def march_on(parameters, method, run, rows, log):
    """March one machine; what the log cannot hold any more is forgotten."""
    run.clock.events = 0
    while march(parameters, method, run, rows, log) == LOG_FULL:
        run.clock.events = 0
