"""The log of events."""

import numpy as np

from omnisim.base.kernel import kernel

EVENT = np.dtype(
    [
        ("time", np.float64),  # s
        ("kind", np.int64),  # index into EVENT_KINDS
        ("wheel", np.int64),
        ("roller_from", np.int64),  # -1 where not meant
        ("roller_to", np.int64),
    ]
)


@kernel
def record(clock, log, time, kind, w, roller_from, roller_to):
    """Append an event; the march makes sure that there is room."""
    event = log[clock.events]
    event.time, event.kind, event.wheel = time, kind, w
    event.roller_from, event.roller_to = roller_from, roller_to
    clock.events += 1
