"""What the floor carries: one interface for normal forces, and their providers side by side.

A provider takes roll and pitch from the machine. It is a number, `upright` of the record MACHINE, and a file:

    servo.py          loads known at once
    rigid_plane.py    loads by unknowns, found together with the acceleration of the body

The forces along the floor ask of it, in solution.py:

    loads_known    whether its loads are known before them
    given_load     then the load of a wheel, else 1 N: what friction at a wheel is counted by
    held_body      where a sticking contact goes into the equations
    solve          the acceleration of the body, and with it loads by unknowns into the workspace

The rows of roll and pitch that providers balance are in tilt.py. What else names a provider: the key `upright`
(scene/schema.py), loads at rest (static_loads.py), what lift-off means (march/events.py).
"""
