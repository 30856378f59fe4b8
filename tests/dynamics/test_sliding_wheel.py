"""The short way of sliding wheels is the general way, only faster."""

import json
import os
import subprocess
import sys

import pytest
import scenes

pytestmark = pytest.mark.short
PATCH = ("friction.law=regularized", "friction.slip_speed=0.01", "friction.contact_torque=contensou",
         "friction.patch_radius=0.003")  # fmt: skip
VISCOUS = ("friction.law=viscous", "friction.viscosity=50")
SCENES = (
    ("six_rollers",),
    ("six_rollers", *VISCOUS),
    ("six_rollers", *PATCH),
    ("coulomb_wheel",),
    ("kiwi",),
    ("kiwi", *PATCH),
    ("kiwi", "scene.upright=servo", *VISCOUS),
    ("youbot",),
    ("youbot", "scene.upright=servo"),
)
# Both ways of every wheel at random speeds: the largest difference of all that a right-hand side writes, by its size.
PROGRAM = """
import json, sys
import numpy as np
import omnisim
from omnisim.dynamics import right_hand_side
from omnisim.dynamics.state import Stage
from scenes import standing

CONTACT = ("force", "torque", "slip", "turn", "l", "axis")
PART = ("normal_force", "drive_torque", "free_spin", "tilt", "contacts", "loaded")
chosen = right_hand_side.slides_alone

def written(parameters, run, y, way):
    right_hand_side.slides_alone = way
    stage = Stage(run.mode, 0, 0.0, y, np.zeros_like(y), run.monitors, True)
    right_hand_side.rhs(parameters, stage)
    contacts, parts = parameters.workspace.contacts[parameters.wheels.contacts], parameters.workspace.parts
    found = {"monitors " + name: run.monitors[name].copy() for name in run.monitors.dtype.names}
    found |= {"contact " + name: contacts[name].copy() for name in CONTACT}
    return found | {"part " + name: parts[name].copy() for name in PART} | {"dy": stage.dy}

def compared(name, overrides):
    parameters, run = standing(omnisim.load(name, overrides))
    random, at, worst, slid = np.random.default_rng(3), parameters.machine.places, 0.0, []
    run.mode.grip[:] = 0
    for _ in range(10):
        y = run.y.copy()
        y[at.velocity:at.friction_loss] += random.normal(size=at.friction_loss - at.velocity)
        short = written(parameters, run, y, chosen)
        slid.append(bool(parameters.workspace.parts.slides.all()))
        for path, values in written(parameters, run, y, lambda machine, mode: False).items():
            worst = max(worst, float(np.abs(short[path] - values).max() / max(1e-6, np.abs(values).max())))
    return worst, all(slid)

print(json.dumps([compared(name, overrides) for name, *overrides in json.loads(sys.argv[1])]))
"""


def test_the_short_way_of_sliding_wheels_is_the_general_way():
    """In plain Python, where the choice between the two can be taken away from the right-hand side."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.path.dirname(scenes.__file__)}
    command = [sys.executable, "-c", PROGRAM, json.dumps(SCENES)]
    output = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    for scene, (worst, slid) in zip(SCENES, json.loads(output), strict=True):
        assert slid, f"{scene}: not all wheels went the short way"
        assert worst < 1e-14, scene  # measured up to 4.4e-16
