"""The packaged coulomb_wheel in MuJoCo, as its users would build it: rollers of the shapes that it knows.

The wheel is one body that slides along x, y and z, yaws and spins, so that joints hold it upright as the servo does;
its rollers are bodies on hinges. Masses and inertias are those of the scene. Rollers touch the floor only.
All that helps is tried: two ellipsoids, meshes of the exact surface, stiff contacts, every integrator, small steps,
and the options that are meant to stop creep.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from bench.common import Claim, table
from bench.peers import wheel_scene
from bench.peers.wheel_scene import BEST, CAPSULE, CELLS, FASTEST, LEVEL, NOTES, SMOOTH, Shape
from omnisim.cad.geometry import roller_frames
from omnisim.cad.robot_description import numbers
from omnisim.scene.wheel_schema import WheelType

try:
    import mujoco
except ImportError:
    mujoco = None

MISSING = "MuJoCo is not installed: `pip install mujoco`, or the extra `peers`."
SHAPES: dict[str, Callable[[WheelType], Shape]] = {
    LEVEL: wheel_scene.level_ellipsoid,
    SMOOTH: wheel_scene.smooth_ellipsoid,
    "mesh, 32 x 64": lambda _: wheel_scene.mesh(32, 64),
    "mesh, 128 x 256": lambda _: wheel_scene.mesh(128, 256),
    CAPSULE: wheel_scene.capsule,
}
SOFT, HARD = "0.9 0.95 0.001", "0.999 0.9999 0.0001"  # solimp: MuJoCo's own, and all but rigid
CONTACTS = {  # solref, of a step in s, and solimp
    "default, 20 ms": (lambda step: "0.02 1", SOFT),
    "4 ms": (lambda step: "0.004 1", SOFT),
    "2 steps": (lambda step: f"{2.0 * step!r} 1", SOFT),
    "2 steps, hard": (lambda step: f"{2.0 * step!r} 1", HARD),
    "direct, 1e6 1/s^2": (lambda step: "-1e6 -2e3", HARD),
}
X, Y, Z, YAW, SPIN = range(5)  # joints of the wheel
MODEL = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{step!r}" integrator="{integrator}" cone="{cone}" impratio="{impratio!r}"
          noslip_iterations="{noslip}" gravity="0 0 {gravity!r}"><flag autoreset="disable"/></option>
  <default>
    <geom solref="{solref}" solimp="{solimp}" friction="{friction!r} 0 0" condim="3" contype="0" conaffinity="1"/>
  </default>
  <asset>{asset}</asset>
  <worldbody>
    <geom type="plane" size="10 10 1" contype="1" conaffinity="0"/>
    <body pos="0 0 {radius!r}">
      <joint type="slide" axis="1 0 0"/> <joint type="slide" axis="0 1 0"/> <joint type="slide" axis="0 0 1"/>
      <joint type="hinge" axis="0 0 1"/> <joint type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{disk}"/>
      {rollers}
    </body>
  </worldbody>
</mujoco>
"""
ROLLER = """
<body pos="{pos}" zaxis="{axis}">
  <joint type="hinge" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>
  <geom {geom}/>
</body>
"""


class Setup(NamedTuple):
    """Rollers as one of SHAPES, one of CONTACTS, an integrator, a step (s), and options of the solver."""

    rollers: str
    contact: str
    integrator: str
    step: float
    cone: str = "elliptic"
    impratio: float = 1.0
    noslip: int = 0


class Plan(NamedTuple):
    """Which rollers x contacts are surveyed, by which integrators x steps the best of them go on."""

    rollers: tuple[str, ...]
    contacts: tuple[str, ...]
    integrators: tuple[str, ...]
    steps: tuple[float, ...]


SURVEY = "implicitfast", 2e-4  # integrator and step, s, of the survey
INTEGRATORS = ("Euler", "implicitfast", "discrete", "RK4")
FULL = Plan(tuple(SHAPES), tuple(CONTACTS), INTEGRATORS, (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5))
SHORT = Plan((LEVEL, SMOOTH), ("default, 20 ms", "2 steps"), ("implicitfast",), (2e-3, 1e-3))
FULL_ROUNDS = 5  # fewer rounds are for the short plan
OPTIONS = {  # against creep, tried on the best
    "pyramidal cone": {"cone": "pyramidal"},
    "impratio 100": {"impratio": 100.0},
    "10 noslip iterations": {"noslip": 10},
}


def model(setup: Setup, friction: float | None = None):
    """The MjModel of a setup; friction: coefficient, that of the scene unless given (MuJoCo raises 0 to 1e-5)."""
    config, kind = wheel_scene.scene().config, wheel_scene.wheel_type()
    solref, solimp = CONTACTS[setup.contact]
    asset, geom = geometry(SHAPES[setup.rollers](kind))
    rollers, disk = roller_bodies(kind, geom), kind.disk
    text = MODEL.format(
        **setup._asdict() | {"rollers": rollers},
        solref=solref(setup.step),
        solimp=solimp,
        friction=config.friction.coefficient if friction is None else friction,
        gravity=-config.world.gravity,
        asset=asset,
        radius=kind.radius,
        mass=disk.mass,
        disk=numbers(disk.inertia_diameter, disk.inertia_axle, disk.inertia_diameter),
    )
    return mujoco.MjModel.from_xml_string(text)


def roller_bodies(kind: WheelType, geom: str, mirrored: bool = False, phase: float = 0.0) -> str:
    """The rollers of a wheel, bodies within that of its disk; phase: azimuth of the first, rad."""
    roller = kind.roller
    inertia = numbers(roller.inertia_transverse, roller.inertia_transverse, roller.inertia_axial)
    return "".join(
        ROLLER.format(pos=numbers(*centre), axis=numbers(*axis), mass=roller.mass, inertia=inertia, geom=geom)
        for centre, axis in roller_frames(kind, mirrored, phase)
    )


def geometry(shape: Shape) -> tuple[str, str]:
    """What goes into <asset>, and the attributes of a roller's <geom>."""
    if shape.kind == "mesh":
        vertices = numbers(*shape.size.ravel())
        return f'<mesh name="roller" inertia="convex" vertex="{vertices}"/>', 'type="mesh" mesh="roller"'
    return "", f'type="{shape.kind}" size="{numbers(*shape.size)}"'


class Running:
    """A run from the start of the scene, or from another velocity (vx, vy in m/s)."""

    def __init__(self, compiled, velocity: tuple[float, float] | None = None):
        config = wheel_scene.scene().config
        self.model, self.data = compiled, mujoco.MjData(compiled)
        self.data.qvel[[X, Y]] = config.initial.velocity if velocity is None else velocity
        self.data.qvel[SPIN] = config.wheels[0].spin_rate

    def advance(self, until: float) -> None:
        """One call, and a loop over the steps in C."""
        mujoco.mj_step(self.model, self.data, nstep=round((until - self.data.time) / self.model.opt.timestep))

    def pose(self) -> tuple[float, float, float, float]:
        x, y, z, yaw = self.data.qpos[[X, Y, Z, YAW]]
        return x, y, z + wheel_scene.wheel_type().radius, yaw

    def speed(self) -> float:
        return float(self.data.qvel[X])


def attempt(setup: Setup) -> dict:
    return setup._asdict() | wheel_scene.observe(Running(model(setup)))._asdict()


def measure(rounds: int) -> dict:
    """A survey, ladders of steps of the best of each kind of roller, and the best of all beside omnisim."""
    if mujoco is None:
        return {}
    plan = FULL if rounds >= FULL_ROUNDS else SHORT
    survey = []
    for rollers in plan.rollers:
        for contact in plan.contacts:
            setup = Setup(rollers, contact, *SURVEY)
            left = wheel_scene.speed_left(Running(model(setup), (wheel_scene.scene().config.initial.velocity[0], 0.0)))
            survey.append(attempt(setup) | {"speed_left": left})
    ladders = []
    for rollers in plan.rollers:
        contact = wheel_scene.best_of([row for row in survey if row["rollers"] == rollers])["contact"]
        for integrator in plan.integrators:
            ladders += [attempt(Setup(rollers, contact, integrator, step)) for step in plan.steps]
    runs = survey + ladders
    most_accurate = wheel_scene.best_of(runs)
    options = {"as it is": most_accurate}
    for name, option in OPTIONS.items():
        options[name] = attempt(setup_of(most_accurate)._replace(**option))
    best, fastest = wheel_scene.best_of(list(options.values())), wheel_scene.fastest_of(runs)
    peers = {BEST: lambda: stepping(setup_of(best)), FASTEST: lambda: stepping(setup_of(fastest))}
    return {
        "version": mujoco.__version__,
        "survey": survey,
        "ladders": ladders,
        "options": options,
        "best": best,
        "fastest": fastest,
        "omnisim": wheel_scene.against(peers, rounds),
    }


def setup_of(row: dict) -> Setup:
    return Setup(**{key: row[key] for key in Setup._fields})


def stepping(setup: Setup) -> Callable[[], None]:
    """A contestant: all steps in one call."""
    run = Running(model(setup))
    return lambda: run.advance(wheel_scene.end())


def report(result: dict) -> str:
    if not result:
        return MISSING
    survey = [
        [row["rollers"], row["contact"], *wheel_scene.cells(row), wheel_scene.speed_cell(row["speed_left"])]
        for row in result["survey"]
    ]
    options = [[name, *wheel_scene.cells(row)] for name, row in result["options"].items()]
    integrator, step = SURVEY
    return "\n\n".join(
        [
            f"MuJoCo {result['version']}, mj_step in a loop in C, elliptic cone, condim 3. Rollers and contacts, "
            f"by {integrator} at {step:g} s:",
            table(["rollers", "contact", *CELLS, "speed left, m/s"], survey),
            truest_heading(result["survey"] + result["ladders"]),
            "Each kind of roller by the contact that suited it best, position off by (mm) at times real time:",
            ladder_table(result["ladders"]),
            f"The best of these ({words(result['options']['as it is'])}) with other options:",
            table(["option", *CELLS], options),
            f"The best of all, and the fastest ({words(result['fastest'])}), beside omnisim, timed in turn:",
            wheel_scene.comparison("MuJoCo", result["best"], result["omnisim"]),
            NOTES,
        ]
    )


def truest_heading(rows: list[dict]) -> str:
    row = min(rows, key=lambda row: row["yaw_error"])
    return (
        f"The smallest error of the yaw in any run here and below is {row['yaw_error']:.1e} rad ({words(row)}), "
        f"with a position off by {row['position_error'] * 1e3:.1f} mm."
    )


def ladder_table(rows: list[dict]) -> str:
    """A line for each ladder, a column for each step."""
    lines: dict[tuple[str, str, str], list[str]] = {}
    for row in rows:
        off, _, _, _, times = wheel_scene.cells(row)
        cell = f"{off} at {times}" if row["seconds"] < math.inf else off
        lines.setdefault((row["rollers"], row["contact"], row["integrator"]), []).append(cell)
    steps = sorted({row["step"] for row in rows}, reverse=True)
    header = ["rollers", "contact", "integrator", *(f"{step:.0e} s" for step in steps)]
    return table(header, [[*key, *line] for key, line in lines.items()])


def words(row: dict) -> str:
    return f"{row['rollers']}; {row['contact']}; {row['integrator']}, {row['step']:g} s"


def claims(result: dict) -> list[Claim]:
    return wheel_scene.claims("MuJoCo", result)
