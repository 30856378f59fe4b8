"""Studies of the kiwi that are soon done, and what is the same of two of them."""

import numpy as np

SCENE = {"schema": 1, "scene": "kiwi", "set": {"time.end": 0.1, "time.output_interval": 0.01}}
MEASURE = {
    "far": {"dataset": "body/position", "at": "end", "component": "norm"},
    "slip": {"dataset": "wheels/*/slip_velocity", "reduce": "max", "component": "norm"},
    "least_load": {"dataset": "wheels/*/normal_force", "reduce": "min"},
    "load": {"dataset": "wheels/left/normal_force", "reduce": "rms"},
    "work": {"dataset": "energy/drive_work", "at": 0.05},
    "drift": {"dataset": "odometry/error", "at": "end", "component": "norm"},
    "impulse": {"dataset": "wheels/*/drive_torque", "reduce": "integral"},
    "swing": {"dataset": "body/yaw_rate", "reduce": "ptp"},
}
GRID = SCENE | {"vary": {"friction.coefficient": [0.1, 0.3, 0.6], "chassis.mass": [3.0, 5.0]}, "measure": MEASURE}
DRAWN = SCENE | {
    "vary": {
        "friction.coefficient": {"mean": 0.4, "deviation": 0.25},  # about one draw in twenty is below zero
        "wheels.*.phase_deg": {"uniform": [0.0, 60.0], "each": True},
    },
    "design": {"kind": "random", "count": 40, "seed": 5},
    "measure": {"far": MEASURE["far"], "slip": MEASURE["slip"]},
}


def numbers(found):
    """All that a study has found but for the time that it took."""
    return {name: values for name, values in found.items() if name != "wall_time"}


def same(one, other):
    assert numbers(one).keys() == numbers(other).keys()
    for name, values in numbers(one).items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)
