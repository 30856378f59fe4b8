"""The mecanum platform of machine_scenes.py in MuJoCo, driven by the same torques: a free chassis on four wheels.

The torques are those by which ideal wheels would follow the motion; after RAMP seconds there are none. So no controller
hides what contacts do, and both simulate the same machine.
"""

import math
import statistics
from collections.abc import Callable
from functools import cache, partial
from typing import NamedTuple

import numpy as np

import omnisim
from bench.common import Claim, interleaved, median_ratio, simulation, table
from bench.machine_scenes import END, RAMP, platform
from bench.peers import wheel_scene
from bench.peers.mujoco_peer import CONTACTS, MISSING, geometry, mujoco, roller_bodies
from bench.peers.wheel_scene import LEVEL, LOST, SMOOTH
from bench.whole_machines import reference
from omnisim.cad.robot_description import numbers
from omnisim.dynamics.packing import pack
from omnisim.results.trajectory import Trajectory
from omnisim.scene.scene import Scene
from omnisim.studies.workers import cores

SHAPES = {LEVEL: wheel_scene.level_ellipsoid, SMOOTH: wheel_scene.smooth_ellipsoid}
STRAIGHT = ("forward", "sideways")  # motions whose odometry needs no yaw
OURS = ("rk4", 1e-2)  # method and step, s, that keep the position within 1e-5 m in every motion
HOW = (("4 ms", "implicitfast", 1e-3), ("2 steps", "Euler", 2e-3), ("2 steps, hard", "implicitfast", 1e-4))
FULL_ROUNDS = 5  # fewer rounds are for one setup of each motion
ALARM = 0.5  # of the time of omnisim.simulate, for the fastest setup
NOTES = """Errors at 2 s against the converged run. Short: distance gone, against that of the wheels' odometry; true
rollers have it, too. The first two rows are omnisim's own."""
MODEL = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{step!r}" integrator="{integrator}" cone="elliptic" gravity="0 0 {gravity!r}">
    <flag autoreset="disable"/>
  </option>
  <default>
    <geom type="ellipsoid" solref="{solref}" solimp="{solimp}" friction="{friction!r} 0 0" condim="3" contype="0"
          conaffinity="1"/>
  </default>
  <worldbody>
    <geom type="plane" size="10 10 1" contype="1" conaffinity="0"/>
    <body>
      <freejoint/>
      <inertial pos="{centre}" mass="{mass!r}" diaginertia="{inertia}"/>
      {wheels}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>
"""
WHEEL = """
<body pos="{pos}">
  <joint name="{name}" type="hinge" axis="0 1 0"/>
  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>
  {rollers}
</body>
"""


class Setup(NamedTuple):
    """One of STRAIGHT, rollers as one of SHAPES, one of CONTACTS, an integrator, a step (s)."""

    motion: str
    rollers: str
    contact: str
    integrator: str
    step: float


@cache
def scene(motion: str) -> Scene:
    return platform(motion, "torque", *OURS)


@cache
def converged(motion: str) -> Trajectory:
    return reference(motion, "torque")


def model(setup: Setup):
    """The MjModel of a setup; its motors are direct, in the order of the wheels."""
    config = scene(setup.motion).config
    kind, chassis = config.wheel_types["wheel"], config.chassis
    disk, (solref, solimp) = kind.disk, CONTACTS[setup.contact]
    _, geom = geometry(SHAPES[setup.rollers](kind))
    wheels = "".join(
        WHEEL.format(
            name=wheel.name,
            pos=numbers(*wheel.position, kind.radius),
            mass=disk.mass,
            inertia=numbers(disk.inertia_diameter, disk.inertia_axle, disk.inertia_diameter),
            rollers=roller_bodies(kind, geom, wheel.mirrored),
        )
        for wheel in config.wheels
    )
    text = MODEL.format(
        step=setup.step,
        integrator=setup.integrator,
        gravity=-config.world.gravity,
        solref=solref(setup.step),
        solimp=solimp,
        friction=config.friction.coefficient,
        centre=numbers(*chassis.center_of_mass),
        mass=chassis.mass,
        inertia=numbers(*chassis.inertia),
        wheels=wheels,
        motors="".join(f'<motor joint="{wheel.name}"/>' for wheel in config.wheels),
    )
    return mujoco.MjModel.from_xml_string(text)


class Running:
    """A run from rest to the end."""

    def __init__(self, setup: Setup):
        self.setup, self.model = setup, model(setup)
        self.data = mujoco.MjData(self.model)
        self.torques = [wheel.drive.torque[0] for wheel in scene(setup.motion).config.wheels]

    def go(self) -> None:
        for torques, seconds in ((self.torques, RAMP), (0.0, END - RAMP)):
            self.data.ctrl[:] = torques
            mujoco.mj_step(self.model, self.data, nstep=round(seconds / self.setup.step))

    def outcome(self) -> dict:
        """At the end: distance from the converged position (m) and yaw (rad), and how far it is short of odometry."""
        x, y, z, w, _, _, turn = self.data.qpos[:7]
        kind, run = scene(self.setup.motion).config.wheel_types["wheel"], converged(self.setup.motion)
        if not abs(z) < LOST * kind.radius:  # true of no number, too
            return {"position_error": math.inf, "yaw_error": math.inf, "short": math.nan}
        rows = pack(scene(self.setup.motion).config).wheels.odometry
        spins = [self.data.joint(name).qpos[0] for name in run.wheels]
        reported = math.hypot(*(np.array(spins) @ rows)[:2])
        return {
            "position_error": math.dist((x, y), run["body/position"][-1, :2]),
            "yaw_error": abs(2.0 * math.atan2(turn, w) - run["body/yaw"][-1]),
            "short": 1.0 - math.hypot(x, y) / reported,
        }


def rollout(setup: Setup, models: list, end: float) -> Callable[[], object]:
    """MuJoCo's runs of these models of a setup up to `end`, s, all at once over all cores; models, states and results
    are made before."""
    from mujoco.rollout import Rollout

    first, data = models[0], [mujoco.MjData(models[0]) for _ in range(cores())]
    state = np.empty(mujoco.mj_stateSize(first, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(first, data[0], state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    steps = round(end / setup.step)
    control = np.zeros((1, steps, first.nu))
    control[:, : round(RAMP / setup.step)] = [wheel.drive.torque[0] for wheel in scene(setup.motion).config.wheels]
    states = np.empty((len(models), steps, len(state)))
    pool = Rollout(nthread=cores())
    return partial(pool.rollout, models, data, state[None], control, state=states, skip_checks=False)


def measure(rounds: int) -> dict:
    """Errors of every setup, and its time over that of omnisim, in turn."""
    if mujoco is None:
        return {}
    full = rounds >= FULL_ROUNDS
    setups = [
        Setup(motion, rollers, *how)
        for motion in STRAIGHT
        for rollers in (SHAPES if full else [LEVEL])
        for how in (HOW if full else HOW[:1])
    ]
    contestants: dict[object, Callable] = {setup: partial(stepping, setup) for setup in setups}
    contestants |= {motion: partial(simulation, scene(motion)) for motion in STRAIGHT}
    seconds = interleaved(contestants, rounds)
    rows = []
    for setup in setups:
        run = Running(setup)
        run.go()
        theirs, ours = seconds[setup], seconds[setup.motion]
        timing = {"seconds": statistics.median(theirs), "ratio": median_ratio(theirs, ours)}
        rows.append(setup._asdict() | run.outcome() | timing)
    return {"rows": rows, "omnisim": [ours_row(motion, statistics.median(seconds[motion])) for motion in STRAIGHT]}


def stepping(setup: Setup) -> Callable[[], None]:
    """A contestant."""
    return Running(setup).go


def ours_row(motion: str, seconds: float) -> dict:
    """The same of omnisim."""
    run, exact = omnisim.simulate(scene(motion)), converged(motion)
    (x, y), reported = run["body/position"][-1, :2], math.hypot(*run["odometry/position"][-1])
    return {
        "motion": motion,
        "position_error": math.dist((x, y), exact["body/position"][-1, :2]),
        "yaw_error": abs(float(run["body/yaw"][-1] - exact["body/yaw"][-1])),
        "short": 1.0 - math.hypot(x, y) / reported,
        "seconds": seconds,
    }


def report(result: dict) -> str:
    if not result:
        return MISSING
    method, step = OURS
    ours = [[row["motion"], "true", "rigid", method, f"{step:g}", *cells(row), 1] for row in result["omnisim"]]
    theirs = [
        [*(row[key] for key in Setup._fields[:-1]), f"{row['step']:g}", *cells(row), f"{row['ratio']:.1f}"]
        for row in result["rows"]
    ]
    header = ["motion", "rollers", "contact", "method", "step, s", "position off by, mm", "yaw off by, rad", "short"]
    header += ["times real time", "takes, times omnisim.simulate"]
    return f"{table(header, ours + theirs)}\n\n{NOTES}"


def cells(row: dict) -> list[str]:
    """Errors, what is short, real-time factor."""
    if row["position_error"] == math.inf:
        return ["fails", "-", "-", "-"]
    off = [f"{row['position_error'] * 1e3:.2g}", f"{row['yaw_error']:.1e}", f"{row['short']:.2%}"]
    return [*off, f"{END / row['seconds']:.0f}"]


def claims(result: dict) -> list[Claim]:
    if not result:
        return []
    least = min(row["ratio"] for row in result["rows"])
    return [Claim("the platform in MuJoCo by its fastest setup, by omnisim.simulate", least, "at least", 1.0, ALARM)]
