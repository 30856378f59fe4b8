"""Machines of which recordings are tested, and their runs, each made once."""

from functools import cache

import tomlkit
from oracle.spatial.states import SCENES as FREE

import omnisim
from omnisim.scene.scene import parse

SHORT = ["time.end=0.03", "time.output_interval=0.01"]
TURNING = ["initial.position=[0.3, -0.2]", "initial.yaw_deg=20.0", "initial.velocity=[0.2, 0.1]",
           "initial.yaw_rate=0.7", "wheels.front_left.heading_deg=12.0", "wheels.rear_right.phase_deg=7.0"]  # fmt: skip
FALLING = ["initial.height=0.1", "initial.roll_deg=8.0", "initial.pitch_deg=-5.0"]
ON_A_BUMP = ["initial.position=[0.1, 0.0]", "initial.height=0.0"]
MACHINES = {
    "mecanum": lambda: omnisim.load("youbot", [*SHORT, *TURNING]),
    "omni": lambda: omnisim.load("kiwi", [*SHORT, "wheels.left.spin_rate=3.0"]),
    "bare wheel": lambda: omnisim.load("six_rollers", SHORT),
    "falling": lambda: parse(tomlkit.dumps(FREE["unlike wheels"]), overrides=[*SHORT, *FALLING]),
    "slope": lambda: parse(tomlkit.dumps(FREE["kiwi_slope"]), overrides=SHORT),
    "rockers": lambda: parse(tomlkit.dumps(FREE["rockers"]), overrides=SHORT),
    "bumps": lambda: parse(tomlkit.dumps(FREE["mecanum_bump"]), overrides=[*SHORT, *ON_A_BUMP]),
}
UPRIGHT = ("mecanum", "omni", "bare wheel")


@cache
def run_of(name):
    return omnisim.simulate(MACHINES[name]())
