"""The mecanum machine of bench/bump_scene.py over bumps in MuJoCo: a free chassis, wheels of rollers, a height field.

Its contacts are soft, and so is the rubber: a contact of MuJoCo can be the spring and damper of the scene (RUBBER).
With a small impedance the mass that feels the contact no longer enters, and a contact presses by -(stiffness r +
damping r') / A, A: inverse mass at the roller as MuJoCo estimates it; so the direct solref is A times the constants of
the rubber. Its friction creeps like a damper of impratio times the same damping: with impratio = creep() that is the
regularized law of the scene about zero slip.

What it does not have: one contact for a roller. Every facet of the ground that overlaps presses by itself, so a finer
field is not a better one, and even on a flat one rollers lose speed at the edges.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bench.bump_scene import bumps, end, errors, heights, wheel_type
from bench.peers import wheel_scene
from bench.peers.mujoco_peer import CONTACTS, geometry, mujoco, roller_bodies
from bench.peers.mujoco_platform import WHEEL
from bench.peers.wheel_scene import LEVEL, LOST, SMOOTH, Shape
from omnisim.cad.geometry import of_type
from omnisim.cad.mesh import roller
from omnisim.cad.robot_description import numbers
from omnisim.contact.roller_profile import length
from omnisim.scene.wheel_schema import WheelType

RUBBER, MESH, CAPSULE = "the rubber's", "mesh, 32 x 64", "capsule"
IMPEDANCE = 1e-3  # of RUBBER: what the mass that feels a contact still matters
GROUND = (-0.5, 1.6, -0.5, 0.5)  # of the height field, m: least and largest x, y


def capsule(kind: WheelType) -> Shape:
    """As long and as thick as the roller."""
    thick = kind.radius - kind.roller_distance
    return Shape("capsule", np.array([thick, 0.5 * length(of_type(kind)) - thick]))


SHAPES: dict[str, Callable[[WheelType], Shape]] = {
    LEVEL: wheel_scene.level_ellipsoid,
    SMOOTH: wheel_scene.smooth_ellipsoid,
    MESH: lambda kind: Shape("mesh", roller(kind, 32, 64).vertices[:-2]),
    CAPSULE: capsule,
}
MODEL = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{step!r}" integrator="{integrator}" cone="elliptic" impratio="{impratio!r}"
          gravity="0 0 {gravity!r}">
    <flag autoreset="disable"/>
  </option>
  <default>
    <geom solref="{solref}" solimp="{solimp}" friction="{friction!r} 0 0" condim="3" contype="0" conaffinity="1"/>
  </default>
  <asset><hfield name="ground" nrow="{rows}" ncol="{columns}" size="{size}"/>{asset}</asset>
  <worldbody>
    <geom type="hfield" hfield="ground" pos="{middle}" contype="1" conaffinity="0"/>
    <body>
      <freejoint/>
      <inertial pos="{centre}" mass="{mass!r}" diaginertia="{inertia}"/>
      {wheels}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>
"""


class Setup(NamedTuple):
    """Rollers as one of SHAPES, RUBBER or one of CONTACTS, an integrator, a step (s), spacing of the heights (m)."""

    rollers: str
    contact: str
    integrator: str
    step: float
    spacing: float
    impratio: float = 1.0


def creep() -> float:
    """impratio by which friction of RUBBER about zero slip is mu N / slip_speed, N: a wheel's share of the weight."""
    config, kind = bumps().config, wheel_type()
    load = weight() / len(config.wheels)
    return config.friction.coefficient * load / (config.friction.slip_speed * kind.contact.damping)


def weight() -> float:
    """Of the whole machine, N."""
    config, kind = bumps().config, wheel_type()
    wheel = kind.disk.mass + kind.roller_count * kind.roller.mass
    return (config.chassis.mass + len(config.wheels) * wheel) * config.world.gravity


def model(setup: Setup):
    """The MjModel of a setup; its motors are direct, in the order of the wheels."""
    config = bumps().config
    kind, chassis = wheel_type(), config.chassis
    disk, (solref, solimp) = kind.disk, CONTACTS.get(setup.contact, (lambda _: "-1 -1", "0.9 0.9 0.001"))
    asset, geom = geometry(SHAPES[setup.rollers](kind))
    wheels = "".join(
        WHEEL.format(
            name=wheel.name,
            pos=numbers(*wheel.position, kind.radius),
            mass=disk.mass,
            inertia=numbers(disk.inertia_diameter, disk.inertia_axle, disk.inertia_diameter),
            rollers=roller_bodies(kind, geom, wheel.mirrored, math.radians(wheel.phase_deg)),
        )
        for wheel in config.wheels
    )
    x0, x1, y0, y1 = GROUND
    x, y = (np.linspace(*ends, round((ends[1] - ends[0]) / setup.spacing) + 1) for ends in ((x0, x1), (y0, y1)))
    z = heights(x[None, :], y[:, None])
    text = MODEL.format(
        step=setup.step,
        integrator=setup.integrator,
        impratio=setup.impratio,
        gravity=-config.world.gravity,
        solref=solref(setup.step),
        solimp=solimp,
        friction=config.friction.coefficient,
        rows=len(y),
        columns=len(x),
        size=numbers((x1 - x0) / 2, (y1 - y0) / 2, z.max(), 0.05),
        middle=numbers((x0 + x1) / 2, (y0 + y1) / 2, 0.0),
        asset=asset,
        centre=numbers(*chassis.center_of_mass),
        mass=chassis.mass,
        inertia=numbers(*chassis.inertia),
        wheels=wheels,
        motors="".join(f'<motor joint="{wheel.name}"/>' for wheel in config.wheels),
    )
    compiled = mujoco.MjModel.from_xml_string(text)
    compiled.hfield_data[:] = (z / z.max()).ravel()
    if setup.contact == RUBBER:
        mobility = compiled.body_invweight0[compiled.geom_bodyid[-1], 0] * (1.0 - IMPEDANCE)
        compiled.geom_solref[:] = -mobility * kind.contact.stiffness, -mobility * kind.contact.damping
        compiled.geom_solimp[:, :2] = IMPEDANCE
    return compiled


class Running:
    """A run from the start of the scene."""

    def __init__(self, setup: Setup):
        config = bumps().config
        self.setup, self.model = setup, model(setup)
        self.data = mujoco.MjData(self.model)
        self.data.qpos[2] = config.initial.height
        self.data.qvel[:2] = config.initial.velocity
        for wheel in config.wheels:
            self.data.joint(wheel.name).qvel[0] = wheel.spin_rate
        self.data.ctrl[:] = [wheel.drive.torque[0] for wheel in config.wheels]

    def go(self) -> None:
        mujoco.mj_step(self.model, self.data, nstep=round(end() / self.setup.step))

    def outcome(self) -> tuple[float, float]:
        """Errors at the end, infinite if the machine is far off the ground or no number."""
        pose = self.data.qpos[:7]
        return errors(pose[:3], pose[3:]) if abs(pose[2]) < LOST else (math.inf, math.inf)
