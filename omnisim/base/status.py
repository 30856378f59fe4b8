"""Codes that the march returns, and the sentence for each; the kinds of events that it logs."""

SAFE_STEP = 0.5  # of the stability limit: the step that a message names
EVENTS_PER_STEP = 4096  # more than this in one step is no progress of time
EVENT_KINDS = (
    "exchange", "stick", "slip", "lift_off", "touch_down", "share_begin", "share_end", "stop", "contact_begin",
    "contact_end",
)  # fmt: skip

(
    RUNNING,
    COMPLETE,
    LOG_FULL,
    INTERRUPTED,
    NO_START,
    NOT_FINITE,
    TOO_STIFF,
    ROCKING,
    CROWDED,
    SLOW_SLIP,
    LIFT_OFF,
    LOST_TRACK,
    NO_CONVERGENCE,
    STIFF_BEARING,
    UNBALANCED,
    RESTLESS,
    TIPPING,
    JAMMED,
    ENDED,
    STIFF_CURRENT,
    CHASSIS_DOWN,
    TOO_MANY_TOUCH,
    HOVERING,
) = range(23)

# What a shorter step may cure; the rest is the motion's own end, or the user's.
CURABLE = frozenset((
    NOT_FINITE, TOO_STIFF, ROCKING, CROWDED, SLOW_SLIP, LOST_TRACK, NO_CONVERGENCE, STIFF_BEARING, STIFF_CURRENT,
    UNBALANCED, RESTLESS,
))  # fmt: skip

SENTENCES = {
    COMPLETE: "complete",
    INTERRUPTED: "interrupted by the user at t = {time:.9g} s",
    ENDED: "ended by its controller at t = {time:.9g} s",
    NO_START: "the motion cannot start: a rate of change at t = 0 is not finite; look at the initial speeds and masses",
    NOT_FINITE: (
        "the motion diverged at t = {time:.9g} s: a state is no longer finite; try time.step below {step:.3g} s"
    ),
    TOO_STIFF: (
        "unstable at t = {time:.9g} s: friction at wheel '{wheel}' relaxes slip at {rate:.3g} 1/s, too fast for "
        "{method} with time.step = {step:.3g} s; use time.step < {limit:.2g} s, method = 'auto', or a softer "
        "law (a larger friction.slip_speed or rolling_rate, a smaller viscosity)"
    ),
    STIFF_BEARING: (
        "bearing friction stops a roller at {rate:.3g} 1/s, too fast for {method} with time.step = {step:.3g} s; use "
        "time.step < {limit:.2g} s, method = 'auto', or softer bearings (a larger bearing_rate, a smaller "
        "bearing_viscosity)"
    ),
    STIFF_CURRENT: (
        "the current of a motor settles at {rate:.3g} 1/s (resistance over inductance), too fast for {method} with "
        "time.step = {step:.3g} s; use time.step < {limit:.2g} s, method = 'auto', or a motor without inductance"
    ),
    UNBALANCED: (
        "inaccurate: at t = {time:.9g} s more than 5 % of the energy of the scene came from nowhere; time.step = "
        "{step:.3g} s is too long for this motion with {method}: use time.step < {tenth:.2g} s or method = 'radau5'; "
        "or masses are too far apart for numbers of 16 digits"
    ),
    RESTLESS: (
        "friction at wheel '{wheel}' changed more than a thousand times in one step at t = {time:.9g} s: time.step = "
        "{step:.3g} s is far too large for it; use a smaller one"
    ),
    ROCKING: (
        "wheel '{wheel}' rocks about the edge between two rollers without progress at t = {time:.9g} s: more than a "
        "thousand swings in one step; try a smaller time.step"
    ),
    CROWDED: (
        "more than {events} events in one step at t = {time:.9g} s: time.step = {step:.3g} s is far too large for "
        "the spin rate of wheel '{wheel}'; try a smaller one"
    ),
    LOST_TRACK: (
        "the implicit tracking lost track of wheel '{wheel}' at t = {time:.9g} s: rho is no unit vector any more with "
        "time.step = {step:.3g} s; use a smaller one, or solver.tracking = 'explicit'"
    ),
    SLOW_SLIP: (
        "wheel '{wheel}' slips too slowly for {method} at t = {time:.9g} s: friction changes slip faster than a "
        "million sub-steps of one step can follow; try law = 'regularized', with a larger slip_speed if it is that "
        "already, or for coulomb friction method = 'radau5'"
    ),
    NO_CONVERGENCE: ("no step from t = {time:.9g} s, however short, solves the equations of the implicit method"),
    TIPPING: (
        "the machine tips at t = {time:.9g} s: wheel '{wheel}' leaves the floor, and the wheels that remain on it "
        "carry no roll and pitch; upright = 'servo' would hold it"
    ),
    JAMMED: (
        "friction jams at t = {time:.9g} s (a Painleve state): no loads of the wheels, none below zero, carry the "
        "machine; most was on wheel '{wheel}'; lower the centre of mass or the friction, or use upright = 'servo'"
    ),
    CHASSIS_DOWN: "the chassis touches the ground at t = {time:.9g} s",
    TOO_MANY_TOUCH: (
        "wheel '{wheel}' touches the ground at more places at once than are followed at t = {time:.9g} s: it lies on "
        "its side or is driven deep into the ground, and neither is modelled"
    ),
    HOVERING: (
        "a roller of wheel '{wheel}' presses and lets go more than a thousand times in one step at t = {time:.9g} s: "
        "friction that does not know the load lifts it as soon as it presses, which is not modelled; use another law "
        "than 'viscous'"
    ),
    LIFT_OFF: (
        "wheel '{wheel}' leaves the floor at t = {time:.9g} s: the vertical force lifts more than the weight; "
        "flight is not modelled, reduce wrench.force z"
    ),
}


def sentence(clock, time: float, wheel: str, method: str) -> str:
    """The status of a run in one sentence; "complete" if it reached its end."""
    limit = SAFE_STEP * clock.stability_limit / clock.rate if clock.rate > 0.0 else 0.0
    return SENTENCES[int(clock.status)].format(
        time=time,
        wheel=wheel,
        method=method,
        step=clock.dt,
        rate=clock.rate,
        limit=limit,
        tenth=0.1 * clock.dt,
        events=EVENTS_PER_STEP,
    )
