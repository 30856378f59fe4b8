"""What bearings of a machine free in space carry: weights at rest, and in motion what those of the rigid machine do.

Every force and moment at random states: oracle/test_spatial.py. Measured values stand beside the bounds.
"""

import numpy as np
from free_machines import free
from machines import CHASSIS, TYPES, machine, run, wheel_mass
from scenes import of_wheels

G = 9.81
OMNI = TYPES["omni"]
TRIANGLE = tuple((0.2 * np.cos(angle), 0.2 * np.sin(angle)) for angle in np.radians([60.0, 180.0, 300.0]))
EACH = CHASSIS["mass"] * G / 3.0  # of the chassis on each axle, N
LOADS = tuple(f"{part}bearing_{what}" for part in ("", "rollers/") for what in ("force", "moment"))


def kiwi(**changed) -> dict:
    """Three wheels on a triangle, the centre of mass in its middle."""
    scene = machine("omni", TRIANGLE, (150.0, 270.0, 30.0), **changed)
    return scene | {"output": {"bearing_loads": True}}


def driven() -> dict:
    """Torques that grow from nothing and stay, on rubber that settles."""
    scene = kiwi(time={"end": 0.3, "step": 2e-5, "output_interval": 0.01})
    scene["friction"] = {"law": "regularized", "coefficient": 0.5, "slip_speed": 0.05}
    for wheel, torque in zip(scene["wheels"], (0.3, 0.2, -0.1), strict=True):
        wheel["drive"] = {"kind": "torque", "times": [0.0, 0.2], "torque": [0.0, torque]}
    return scene


def test_at_rest_bearings_carry_weights():
    """The chassis rests on the axles, the wheel on its lowest roller, every other roller hangs in its bearing."""
    motion = run(free(kiwi(time={"end": 0.01, "step": 1e-4, "output_interval": 0.01})))
    force, moment, rollers, turning = (of_wheels(motion, path) for path in LOADS)
    assert np.abs(force - [0.0, 0.0, -EACH]).max() < 1e-10 * EACH  # measured 3e-13
    assert np.abs(moment).max() < 1e-12  # N m; 1e-15
    q = 2.0 * np.pi / OMNI["roller_count"] * np.arange(OMNI["roller_count"])
    expected = OMNI["roller"]["mass"] * G * np.stack([-np.cos(q), 0.0 * q, -np.sin(q)], axis=-1)  # n along d, a x d, a
    expected[0, 0] += EACH + wheel_mass("omni") * G
    assert np.abs(rollers - expected).max() < 1e-10 * EACH  # 3e-13
    assert np.abs(turning).max() < 1e-12  # 1e-15


def test_on_stiff_rubber_axles_carry_what_those_of_the_rigid_machine_do():
    """The difference falls with 1 / stiffness but where two rollers share a load, so half of the rows count."""
    rigid, apart = run(driven()), []
    assert np.abs(rigid["wheels/w0/bearing_moment"][-1, 1] - 0.3) < 1e-12  # along k: the drive
    for stiffness in (1e7, 1e8):
        soft = run(free(driven(), stiffness, damping=4.0 * np.sqrt(stiffness)))
        assert soft.complete
        apart.append([np.median(np.abs(of_wheels(soft, path) - of_wheels(rigid, path)).reshape(31, -1).max(axis=1))
                      for path in LOADS])  # fmt: skip
    force, moment, rollers, turning = apart[-1]
    assert max(force, rollers) < 1e-4  # N, of 20; measured 1.1e-5
    assert max(moment, turning) < 1e-6  # N m, of 0.4; 2.4e-7
    ratio = np.divide(*apart)
    assert ratio.min() > 8.0 and ratio.max() < 12.0, ratio  # 9.2 to 10.0
