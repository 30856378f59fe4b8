"""The packaged coulomb_wheel in Drake: compliant point contact, rollers as ellipsoids, discrete solvers.

As in MuJoCo, joints hold the wheel upright: three sliding ones, yaw and spin; rollers hang on hinges and touch the
floor only. Masses and inertias are those of the scene.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bench.common import Claim, table
from bench.peers import wheel_scene
from bench.peers.wheel_scene import BEST, CELLS, FAILED, FASTEST, LEVEL, NOTES, SMOOTH
from omnisim.cad.geometry import roller_frames

try:
    from pydrake.geometry import (
        AddContactMaterial,
        CollisionFilterDeclaration,
        Ellipsoid,
        GeometrySet,
        HalfSpace,
        ProximityProperties,
    )
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody.plant import (
        AddMultibodyPlantSceneGraph,
        ContactModel,
        CoulombFriction,
        DiscreteContactApproximation,
    )
    from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder
except ImportError as error:
    MISSING: str | None = f"Drake cannot be imported ({error}): `pip install drake`, or the extra `peers`."
else:
    MISSING = None

SHAPES = {LEVEL: wheel_scene.level_ellipsoid, SMOOTH: wheel_scene.smooth_ellipsoid}
SOLVERS = {"TAMSI": "kTamsi", "SAP": "kSap"}
STIFFNESSES = {"default": None, "1e7 N/m": 1e7}
STEPS = (1e-3, 2.5e-4)
CREEP = 1e-4  # m/s: slip below which TAMSI lets friction stick; its default is 1e-3
FULL_ROUNDS = 5  # fewer rounds are for one kind of roller and the larger step
JOINTS = ("x", "y", "z", "yaw", "spin")


class Setup(NamedTuple):
    """Rollers as one of SHAPES, one of SOLVERS, one of STIFFNESSES, a step (s)."""

    rollers: str
    solver: str
    stiffness: str
    step: float


class Wheel:
    """A diagram of the wheel alone on the floor. friction: coefficient, that of the scene unless given."""

    def __init__(self, setup: Setup, friction: float | None = None):
        builder = DiagramBuilder()
        self.plant, geometry = AddMultibodyPlantSceneGraph(builder, setup.step)
        self.plant.set_contact_model(ContactModel.kPoint)
        self.plant.set_discrete_contact_approximation(getattr(DiscreteContactApproximation, SOLVERS[setup.solver]))
        self.plant.set_stiction_tolerance(CREEP)
        config = wheel_scene.scene().config
        self.plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -config.world.gravity])
        mu = config.friction.coefficient if friction is None else friction
        surface = ProximityProperties()
        AddContactMaterial(
            point_stiffness=STIFFNESSES[setup.stiffness], friction=CoulombFriction(mu, mu), properties=surface
        )
        self.plant.RegisterCollisionGeometry(self.plant.world_body(), RigidTransform(), HalfSpace(), "floor", surface)
        self.joints = self._carriage()
        rollers = self._rollers(SHAPES[setup.rollers](wheel_scene.wheel_type()).size, surface)
        self.plant.Finalize()
        geometry.collision_filter_manager().Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(rollers)))
        self.diagram = builder.Build()

    def _carriage(self) -> dict:
        """Joints x, y, z, yaw, spin from the world to the disk, the only one of their bodies that has a mass."""
        disk = wheel_scene.wheel_type().disk
        inertia = rotor(disk.mass, disk.inertia_diameter, disk.inertia_axle, disk.inertia_diameter)
        joints, parent = {}, self.plant.world_body()
        axes = dict(zip(JOINTS, [*np.eye(3), np.eye(3)[2], np.eye(3)[1]], strict=True))
        for name, axis in axes.items():
            body = self.plant.AddRigidBody(name, inertia if name == "spin" else SpatialInertia.Zero())
            joint = RevoluteJoint if name in ("yaw", "spin") else PrismaticJoint
            joints[name] = self.plant.AddJoint(joint(name, parent.body_frame(), body.body_frame(), axis))
            parent = body
        return joints

    def _rollers(self, semi_axes: np.ndarray, surface) -> list:
        """Hang the rollers on the disk; their geometries."""
        kind, disk = wheel_scene.wheel_type(), self.plant.GetBodyByName("spin")
        roller, axle, geometries = kind.roller, np.array([0.0, 1.0, 0.0]), []
        inertia = rotor(roller.mass, roller.inertia_transverse, roller.inertia_transverse, roller.inertia_axial)
        for number, (centre, axis) in enumerate(roller_frames(kind)):
            name = f"roller {number}"
            turned = RotationMatrix(np.column_stack([axle, np.cross(axis, axle), axis]))
            seat = FixedOffsetFrame(f"seat {number}", disk.body_frame(), RigidTransform(turned, centre))
            body = self.plant.AddRigidBody(name, inertia)
            self.plant.AddJoint(RevoluteJoint(name, self.plant.AddFrame(seat), body.body_frame(), [0.0, 0.0, 1.0]))
            geometries.append(
                self.plant.RegisterCollisionGeometry(body, RigidTransform(), Ellipsoid(*semi_axes), name, surface)
            )
        return geometries


def rotor(mass: float, *inertia: float):
    """Spatial inertia of a body about its own centre, kg and kg m^2."""
    return SpatialInertia(mass, np.zeros(3), UnitInertia(*(value / mass for value in inertia)))


class Running:
    """A run from the start of the scene, or from another velocity (vx, vy in m/s)."""

    def __init__(self, wheel: Wheel, velocity: tuple[float, float] | None = None):
        config = wheel_scene.scene().config
        self.joints, self.simulator = wheel.joints, Simulator(wheel.diagram)
        self.context = wheel.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        vx, vy = config.initial.velocity if velocity is None else velocity
        self.joints["x"].set_translation_rate(self.context, vx)
        self.joints["y"].set_translation_rate(self.context, vy)
        self.joints["z"].set_translation(self.context, wheel_scene.wheel_type().radius)
        self.joints["spin"].set_angular_rate(self.context, config.wheels[0].spin_rate)
        self.simulator.Initialize()

    def advance(self, until: float) -> None:
        self.simulator.AdvanceTo(until)

    def pose(self) -> tuple[float, float, float, float]:
        x, y, z = (self.joints[name].get_translation(self.context) for name in "xyz")
        return x, y, z, self.joints["yaw"].get_angle(self.context)

    def speed(self) -> float:
        return self.joints["x"].get_translation_rate(self.context)


def attempt(setup: Setup) -> dict:
    """Outcome and speed left; a solver that gives up raises, and the run has failed."""
    try:
        outcome = wheel_scene.observe(Running(Wheel(setup)))
        straight = (wheel_scene.scene().config.initial.velocity[0], 0.0)
        left = wheel_scene.speed_left(Running(Wheel(setup), straight))
    except RuntimeError:
        outcome, left = FAILED, math.nan
    return setup._asdict() | outcome._asdict() | {"speed_left": left}


def measure(rounds: int) -> dict:
    """Every setup, and the best and the fastest beside omnisim."""
    if MISSING:
        return {}
    rollers, steps = (tuple(SHAPES), STEPS) if rounds >= FULL_ROUNDS else ((LEVEL,), STEPS[:1])
    rows = [
        attempt(Setup(shape, solver, stiffness, step))
        for shape in rollers
        for solver in SOLVERS
        for stiffness in STIFFNESSES
        for step in steps
    ]
    best, fastest = wheel_scene.best_of(rows), wheel_scene.fastest_of(rows)
    peers = {BEST: lambda: stepping(best), FASTEST: lambda: stepping(fastest)}
    return {"rows": rows, "best": best, "fastest": fastest, "omnisim": wheel_scene.against(peers, rounds)}


def stepping(row: dict) -> Callable[[], None]:
    """A contestant: all steps in one call."""
    run = Running(Wheel(Setup(**{key: row[key] for key in Setup._fields})))
    return lambda: run.advance(wheel_scene.end())


def report(result: dict) -> str:
    if not result:
        return str(MISSING)
    rows = []
    for row in result["rows"]:
        setup = [row[key] for key in Setup._fields]
        rows.append([*setup, *wheel_scene.cells(row), wheel_scene.speed_cell(row["speed_left"])])
    best, fastest = (
        f"{row['rollers']}; {row['solver']}; {row['stiffness']}, {row['step']:g} s"
        for row in (result["best"], result["fastest"])
    )
    return "\n\n".join(
        [
            f"Drake, point contact, TAMSI with a stiction tolerance of {CREEP:g} m/s:",
            table(["rollers", "solver", "stiffness", "step, s", *CELLS, "speed left, m/s"], rows),
            f"The best ({best}) and the fastest ({fastest}) beside omnisim, timed in turn:",
            wheel_scene.comparison("Drake", result["best"], result["omnisim"]),
            NOTES,
        ]
    )


def claims(result: dict) -> list[Claim]:
    return wheel_scene.claims("Drake", result)
