"""The order of the state vector, and the mode that is frozen within a step.

    y = [ body: x y yaw V_x V_y yaw_rate | works: friction_loss drive_work wrench_work |
          of each wheel: spin_angle spin_rate roller_rate | implicit tracking only: rho of every roller ]

`roller_rate` is the absolute axial rate p of the roller in contact; the rollers in the air keep theirs exactly and
stand in `rates`, outside the state. The works are integrated with the motion by the same tableau.
"""

import numpy as np

X, Y, YAW, V_X, V_Y, YAW_RATE = range(6)
FRICTION_LOSS, DRIVE_WORK, WRENCH_WORK = range(6, 9)
WHEELS = 9
SPIN_ANGLE, SPIN_RATE, ROLLER_RATE = range(3)
PER_WHEEL = 3

MODE = np.dtype(
    [
        ("roller", np.int64),  # of the contact, counted on through every turn: its index is roller mod N_r
        ("direction", np.int64),  # +1 or -1: sense in which the spin angle runs throughout a step
        ("saturated", np.int64),  # branch of the saturated friction law
        ("air_cos", np.float64),  # sums over the rollers in the air, D_i = gamma_i - gamma_contact:
        ("air_sin", np.float64),  # sum p_i cos D_i, sum p_i sin D_i and sum p_i, rad/s
        ("air_sum", np.float64),
    ]
)
WATCH = np.dtype(
    [
        ("normal_force", np.float64),  # N
        ("slip_square", np.float64),  # |v|^2, m^2/s^2
        ("factor", np.float64),  # g of the friction law F = -g v, N s/m
    ]
)
