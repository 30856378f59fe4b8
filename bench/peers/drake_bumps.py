"""The mecanum machine of bench/bump_scene.py over bumps in Drake: rollers as ellipsoids, ground of triangles.

Drake has no field of heights, and its point contact knows convex bodies only. So the ground is a rigid surface of
triangles and the rollers are compliant: hydroelastic contact, whose pressure rises with depth. Its modulus (Pa) stands
for the stiffness of the rubber, its Hunt-Crossley dissipation (s/m) for the damping.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bench import bump_scene
from bench.bump_scene import COLUMNS, NOTES, attempt, bumps, cells, end, errors, heights, wheel_type
from bench.common import Claim, table
from bench.peers import wheel_scene
from bench.peers.drake_peer import MISSING, SOLVERS, rotor
from bench.peers.mujoco_ground import GROUND
from bench.peers.wheel_scene import LEVEL, LOST, SMOOTH
from omnisim.cad.geometry import roller_frames

if MISSING is None:
    from pydrake.common import MemoryFile
    from pydrake.geometry import (
        AddCompliantHydroelasticProperties,
        AddContactMaterial,
        AddRigidHydroelasticProperties,
        CollisionFilterDeclaration,
        Ellipsoid,
        GeometrySet,
        InMemoryMesh,
        Mesh,
        ProximityProperties,
    )
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody.math import SpatialVelocity
    from pydrake.multibody.plant import (
        AddMultibodyPlantSceneGraph,
        ContactModel,
        CoulombFriction,
        DiscreteContactApproximation,
    )
    from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, RotationalInertia, SpatialInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

SHAPES = {LEVEL: wheel_scene.level_ellipsoid, SMOOTH: wheel_scene.smooth_ellipsoid}


class Setup(NamedTuple):
    """Rollers as one of SHAPES, one of SOLVERS, modulus (Pa), step (s), spacing of the heights and of rollers (m)."""

    rollers: str
    solver: str
    modulus: float
    step: float
    spacing: float = 0.02
    facets: float = 0.005
    dissipation: float = 1.0


class Machine:
    """A diagram of the machine on the ground."""

    def __init__(self, setup: Setup):
        config, kind = bumps().config, wheel_type()
        builder = DiagramBuilder()
        self.plant, geometry = AddMultibodyPlantSceneGraph(builder, setup.step)
        self.plant.set_contact_model(ContactModel.kHydroelastic)
        self.plant.set_discrete_contact_approximation(getattr(DiscreteContactApproximation, SOLVERS[setup.solver]))
        self.plant.set_stiction_tolerance(config.friction.slip_speed)
        self.plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -config.world.gravity])
        self.ground(setup)
        self.body = self.plant.AddRigidBody(
            "chassis",
            SpatialInertia.MakeFromCentralInertia(
                config.chassis.mass, np.array(config.chassis.center_of_mass), RotationalInertia(*config.chassis.inertia)
            ),
        )
        surface = self.material(setup)
        AddCompliantHydroelasticProperties(setup.facets, setup.modulus, surface)
        self.spins, geometries, disk = [], [], kind.disk
        inertia = rotor(disk.mass, disk.inertia_diameter, disk.inertia_axle, disk.inertia_diameter)
        for wheel in config.wheels:
            hub = self.plant.AddRigidBody(wheel.name, inertia)
            seat = self.seat(self.body, RigidTransform([*wheel.position, kind.radius]), f"hub {wheel.name}")
            self.spins.append(self.plant.AddJoint(RevoluteJoint(wheel.name, seat, hub.body_frame(), [0.0, 1.0, 0.0])))
            self.plant.AddJointActuator(wheel.name, self.spins[-1])
            geometries += self.rollers(setup, wheel, hub, surface)
        self.plant.Finalize()
        geometry.collision_filter_manager().Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(geometries)))
        self.diagram = builder.Build()

    def material(self, setup: Setup):
        surface, mu = ProximityProperties(), bumps().config.friction.coefficient
        AddContactMaterial(dissipation=setup.dissipation, friction=CoulombFriction(mu, mu), properties=surface)
        return surface

    def seat(self, body, place, name: str):
        return self.plant.AddFrame(FixedOffsetFrame(name, body.body_frame(), place))

    def ground(self, setup: Setup) -> None:
        """Triangles between the heights, two to a square."""
        x0, x1, y0, y1 = GROUND
        x, y = (np.linspace(*e, round((e[1] - e[0]) / setup.spacing) + 1) for e in ((x0, x1), (y0, y1)))
        u, v = (part.ravel() for part in np.meshgrid(x, y))
        lines = [f"v {a!r} {b!r} {c!r}" for a, b, c in np.column_stack([u, v, heights(u, v)]).tolist()]
        n = len(x)
        for i in range(len(y) - 1):
            for j in range(n - 1):
                a = i * n + j + 1
                lines += [f"f {a} {a + 1} {a + n + 1}", f"f {a} {a + n + 1} {a + n}"]
        surface = self.material(setup)
        AddRigidHydroelasticProperties(setup.spacing, surface)
        self.plant.RegisterCollisionGeometry(
            self.plant.world_body(),
            RigidTransform(),
            Mesh(InMemoryMesh(mesh_file=MemoryFile("\n".join(lines), ".obj", "ground"))),
            "ground",
            surface,
        )

    def rollers(self, setup: Setup, wheel, hub, surface) -> list:
        """Hang the rollers on a hub; their geometries."""
        kind, geometries = wheel_type(), []
        roller, size = kind.roller, SHAPES[setup.rollers](kind).size
        inertia = rotor(roller.mass, roller.inertia_transverse, roller.inertia_transverse, roller.inertia_axial)
        frames = roller_frames(kind, wheel.mirrored, math.radians(wheel.phase_deg))
        for number, (centre, axis) in enumerate(frames):
            name = f"{wheel.name} {number}"
            side = np.cross(axis, centre) / np.linalg.norm(np.cross(axis, centre))
            turned = RotationMatrix(np.column_stack([side, np.cross(axis, side), axis]))
            body = self.plant.AddRigidBody(name, inertia)
            seat = self.seat(hub, RigidTransform(turned, centre), f"seat {name}")
            self.plant.AddJoint(RevoluteJoint(name, seat, body.body_frame(), [0.0, 0.0, 1.0]))
            geometries.append(
                self.plant.RegisterCollisionGeometry(body, RigidTransform(), Ellipsoid(*size), name, surface)
            )
        return geometries


class Running:
    """A run from the start of the scene."""

    def __init__(self, setup: Setup):
        config, machine = bumps().config, Machine(setup)
        self.machine, self.simulator = machine, Simulator(machine.diagram)
        plant = machine.plant
        self.context = plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        plant.SetFreeBodyPose(self.context, machine.body, RigidTransform([0.0, 0.0, config.initial.height]))
        velocity = SpatialVelocity(np.zeros(3), np.array([*config.initial.velocity, 0.0]))
        plant.SetFreeBodySpatialVelocity(context=self.context, body=machine.body, V_JpJc=velocity)
        for wheel, joint in zip(config.wheels, machine.spins, strict=True):
            joint.set_angular_rate(self.context, wheel.spin_rate)
        torques = [wheel.drive.torque[0] for wheel in config.wheels]
        plant.get_actuation_input_port().FixValue(self.context, torques)
        self.simulator.Initialize()

    def go(self) -> None:
        self.simulator.AdvanceTo(end())

    def outcome(self) -> tuple[float, float]:
        pose = self.machine.plant.EvalBodyPoseInWorld(self.context, self.machine.body)
        place = pose.translation()
        return errors(place, pose.rotation().ToQuaternion().wxyz()) if abs(place[2]) < LOST else (math.inf, math.inf)


MODULI = (1e7, 1e8)  # Pa
STEP = 1e-3  # s, of the survey
FULL_ROUNDS = 3  # fewer rounds are for one run


def measure(rounds: int) -> dict:
    """Every setup, changes of the best, and the best beside omnisim."""
    if MISSING:
        return {}
    full = rounds >= FULL_ROUNDS
    setups = [Setup(shape, solver, modulus, STEP) for shape in SHAPES for solver in SOLVERS for modulus in MODULI]
    survey = [tried(setup) for setup in (setups if full else setups[:1])]
    best, changed = setup_of(wheel_scene.best_of(survey)), []
    if full:
        changes = ({"step": 2.5e-4}, {"spacing": 0.04}, {"spacing": 0.01}, {"facets": 0.003}, {"dissipation": 10.0},
                   {"dissipation": 0.1}, {"modulus": 1e6}, {"modulus": 1e9})  # fmt: skip
        changed = [tried(best._replace(**change)) for change in changes]
    judged = bump_scene.judged([*survey, *changed], stepping, rounds, full)
    return {"survey": survey, "changed": changed} | judged


def tried(setup: Setup) -> dict:
    """An attempt; a solver that gives up raises, and the run has failed."""
    try:
        return attempt(setup, Running)
    except RuntimeError:
        return setup._asdict() | {"position_error": math.inf, "turn_error": math.inf, "seconds": math.inf}


def setup_of(row: dict) -> Setup:
    return Setup(**{key: row[key] for key in Setup._fields})


def stepping(row: dict) -> Callable[[], None]:
    """A contestant: all steps in one call."""
    return Running(setup_of(row)).go


def report(result: dict) -> str:
    if not result:
        return str(MISSING)
    heading = ["rollers", "solver", "modulus, Pa", "step, s", "heights every, mm", "facets of rollers, mm",
               "dissipation, s/m", *COLUMNS]  # fmt: skip
    survey, changed = ([[*words(row), *cells(row)] for row in result[name]] for name in ("survey", "changed"))
    return "\n\n".join(
        [
            "Drake, hydroelastic contact:",
            table(heading, survey),
            "The best of these, changed in one thing:",
            table(heading, changed),
            f"The best of all ({', '.join(words(result['best']))}) and the fastest within {bump_scene.NEAR:g} m "
            f"({', '.join(words(result['fastest']))}) beside marches of omnisim, timed in turn:",
            bump_scene.comparison("Drake", result),
            NOTES,
        ]
    )


def words(row: dict) -> list[str]:
    lengths = [f"{row[key] * 1e3:g}" for key in ("spacing", "facets")]
    return [
        row["rollers"],
        row["solver"],
        f"{row['modulus']:.0e}",
        f"{row['step']:g}",
        *lengths,
        f"{row['dissipation']:g}",
    ]


def claims(result: dict) -> list[Claim]:
    return bump_scene.claims("Drake", result)
