"""Impulses at the contacts of a machine free in space: what is left of slip that has come to its end, and what creeping
slip has across its direction, is taken away at once."""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import dot, minus, plus, times
from omnisim.dynamics.spatial.acceleration import slip_at
from omnisim.dynamics.spatial.held import factorize_firm, find_mobility, gather, rate_of, stick
from omnisim.dynamics.spatial.pose import body_of, outward, put_at, vector
from omnisim.dynamics.spatial.pose import turned as turned_about
from omnisim.dynamics.spatial.seen import look_at_all
from omnisim.dynamics.spatial.touching import rate_of_roller
from omnisim.dynamics.state import places


@outlined
def align_in_space(parameters, mode, y, dt):
    """Change the speeds in y by the impulses that leave no slip to sticking contacts, and none across their direction
    to creeping ones, all at once.

    Friction turns creeping slip by forces across it, and these impulses are across it too: a wheel that stands on two
    rollers slips on one of them as it must, and whatever held that slip would move the machine. Slip that all of their
    friction could not turn in a step dt is left as it is.
    """
    body = body_of(parameters, y)
    look_at_all(parameters, mode, body, y)
    count = gather(parameters, mode, body, True)
    if count == 0:
        return
    holding, at = parameters.space.holding, places(parameters)
    for m in range(count):
        held = holding.contacts[m]
        slip = slip_at(parameters, mode[held.wheel], held.wheel, held.contact, y)
        held.bias[0], held.bias[1] = slip.h, slip.k
        if held.creeps:
            u = mode[held.wheel].creep[held.contact]
            held.bias[0], held.bias[1] = slip.k * u[0] - slip.h * u[1], 0.0
        held.force[0] = held.force[1] = 0.0
    find_mobility(parameters, count)
    stick(holding, count, factorize_firm(holding, count))
    if spared(holding, count, dt):
        stick(holding, count, factorize_firm(holding, count))
    before = parameters.space.shifted
    for i in range(len(before)):
        before[i] = y[i]
    for m in range(count):
        kick(parameters, body, mode, y, m, count)
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        y[at.spin_rate + w] -= wheel.axle_inertia * wheel.spin_mobility * turned_faster(parameters, w, before, y)


@kernel
def spared(holding, count, dt):
    """Whether slip of creeping contacts is out of reach of their friction: then the impulses on all others are to be
    found anew, without any on these."""
    found = False
    for m in range(count):
        held = holding.contacts[m]
        if held.creeps and abs(held.force[0]) > held.limit * dt:
            held.firm, found = 0, True
    for m in range(count):
        if found:
            holding.contacts[m].force[0] = holding.contacts[m].force[1] = 0.0
    return found


@kernel
def turned_faster(parameters, w, before, y):
    """What the rate of the carrier of wheel w about k has gained from one state to another at the same place, rad/s."""
    space, at = parameters.space, places(parameters)
    gained = minus(vector(y, at.rate), vector(before, at.rate))
    k, j = vector(space.hubs[w].k, 0), space.hubs[w].carrier
    if j >= 0 and space.carriers[j].turns:
        axis = vector(space.carriers[j].axis, 0)
        k = turned_about(k, axis, space.motions[j].cos, space.motions[j].sin)
        gained = plus(gained, times(y[at.joint_rate + j] - before[at.joint_rate + j], axis))
    return dot(k, gained)


@kernel
def kick(parameters, body, mode, y, m, count):
    """The impulse at contact m into the speeds in y; axles as if their carriers turned no faster."""
    space, at = parameters.space, places(parameters)
    held = space.holding.contacts[m]
    w, impulse = held.wheel, held.force
    wheel = parameters.wheels[w]
    place = rate_of_roller(parameters, mode[w], w, held.contact)
    for e in range(held.firm):
        given = space.holding.given[m, e]
        linear = outward(body.rotation, times(impulse[e], vector(given, 3)))
        put_at(y, at.velocity, plus(vector(y, at.velocity), linear))
        put_at(y, at.rate, plus(vector(y, at.rate), times(impulse[e], vector(given, 0))))
        for j in range(6, len(space.answer)):
            y[at.joint_rate + j - 6] += impulse[e] * given[j]
        y[place] += wheel.axial_mobility * held.arm[e] * impulse[e]
        y[at.spin_rate + w] += wheel.spin_mobility * held.spin[e] * impulse[e]
        if wheel.follows:  # its drive holds the rate against the impulse
            y[at.drive_work] -= held.spin[e] * impulse[e] * y[at.spin_rate + w]
        left = rate_of(space.holding, m, e, count)  # of the slip
        y[at.friction_loss] -= impulse[e] * 0.5 * (held.bias[e] + left)
