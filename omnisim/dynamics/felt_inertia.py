"""The inertia that drives feel while no wheel slips, and how much an estimate of the scene matters to the motion."""

import math

import numpy as np

from omnisim.dynamics.inertia import axle_inertia
from omnisim.dynamics.packing import bodies, pack
from omnisim.dynamics.parameters import SERVO
from omnisim.dynamics.static_loads import loads_under
from omnisim.scene.drives import drive_law
from omnisim.scene.estimates import varied
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import KeyPath

MORE = 0.1  # of an estimate
PUSH = 1.0  # m/s^2


def felt_inertia(config: Config) -> np.ndarray:
    """Twice the kinetic energy of the unit motions of the common centre of mass, (3,): 1 m/s ahead and to the left, kg,
    1 rad/s of yaw, kg m^2. Wheels stand on the middle of a roller, which rolls; rollers in the air do not turn.

        2 T = M V^2 + I_z yaw_rate^2 + sum_w [(J_k + J_r) phi'^2 + Ia p^2]
        phi' = (V_h - tan(psi) V_k) / R        p = V_k / ((R - R1) c) + phi' s        (no slip at q = 0)
    """
    whole = bodies(config)
    x_centre, y_centre, _ = whole.centre
    twists = np.eye(3)
    twists[2, :2] = y_centre, -x_centre  # of the chassis origin, while the machine turns about its centre
    spins = wheel_rows(config) @ twists.T  # (W, 3)
    felt = np.array([whole.mass, whole.mass, whole.yaw_inertia])
    for wheel, spin in zip(config.wheels, spins, strict=True):
        kind = config.type_of(wheel)
        psi = math.radians(-kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg)
        heading = math.radians(wheel.heading_deg)
        x, y = wheel.position
        across = -(twists[:, 0] - twists[:, 2] * y) * math.sin(heading)
        across += (twists[:, 1] + twists[:, 2] * x) * math.cos(heading)  # V_k in each of the motions
        rolling = across / ((kind.radius - kind.roller_distance) * math.cos(psi)) + spin * math.sin(psi)
        felt += (axle_inertia(kind, math.sin(psi)) + drive_law(wheel.drive).rotor_inertia) * spin**2
        felt += kind.roller.inertia_axial * rolling**2
    return felt


def influence(config: Config, path: KeyPath) -> tuple[float, float, float, float]:
    """What 10 % more of an estimate changes, relative: the felt inertia ahead, to the left and turning; and the load of
    a wheel, at most, while the machine accelerates at 1 m/s^2 ahead or to the left, in mean loads."""
    other = varied(config, path, 1.0 + MORE)
    loads, changed = pushed_loads(config), pushed_loads(other)
    mean = float(loads.mean())
    ahead, left, turning = (felt_inertia(other) / felt_inertia(config) - 1.0).tolist()
    return ahead, left, turning, float(np.abs(changed - loads).max()) / mean if mean > 0.0 else 0.0


def pushed_loads(config: Config) -> np.ndarray:
    """Normal forces of the wheels at 1 m/s^2 ahead and to the left, (2, W), N; of a level floor."""
    parameters = pack(config)
    machine = parameters.machine
    weight, push = machine.mass * machine.gravity, -PUSH * machine.mass
    if machine.upright == SERVO:
        push = 0.0
    return np.array([loads_under(parameters, weight, (push, 0.0)), loads_under(parameters, weight, (0.0, push))])
