"""Machines free in space: the engine's right-hand side against one dense solve of all free bodies and multipliers.

At states of all kinds, put into both: standing and leaning, every rate unequal zero, on slopes, bumps, grids, edges,
springs and rockers, with rows and barrels. Values above 1 are compared relative to the largest of their kind.
"""

import numpy as np
import pytest
import tomlkit
from scenes import packed

import omnisim
from omnisim.dynamics.spatial.bearing_loads import recover_in_space
from omnisim.dynamics.spatial.energy import motion_energy, stored_energy
from omnisim.dynamics.spatial.records import ORIENTATION, POSITION, SLOTS
from omnisim.dynamics.state import places_in
from omnisim.march.spatial_contacts import stand_in_space
from omnisim.scene.scene import parse
from oracle.spatial.bodies import Coordinates, Layout, placed, rotation, turned
from oracle.spatial.machine import Machine, Reactions
from oracle.spatial.motion import energy
from oracle.spatial.states import GRID, SCENES, changed, heights, states
from oracle.vectors import cross

SMOOTH = [name for name, scene in SCENES.items() if scene["friction"]["law"] != "coulomb"]
SLOW = ("brush of several lobes", "shapes on bumps", "kerb", "ribs", "long shapes",  # seconds even of few states
        "24 rollers", "grid", "rolling resistance on a bump", "rolling resistance on springs", "brush on a bump",
        "brush on springs")  # fmt: skip
FEW, MANY = 10, 60  # states of a scene
LOSSES = {"friction_loss": "friction", "contact_loss": "contact", "damper_loss": "damper", "drive_work": "drive",
          "wrench_work": "wrench", "bearing_loss": "bearing", "rolling_loss": "rolling"}  # fmt: skip


class Engine:
    """The right-hand side of a scene at states of the oracle."""

    def __init__(self, scene: omnisim.Scene, layout: Layout) -> None:
        self.scene, self.layout = scene, layout
        self.parameters, _ = packed(self.scene)
        self.at = places_in(self.parameters)
        self.origin = np.array(self.parameters.space.body.origin)  # of the chassis from C, chassis axes
        self.wheels = len(layout.wheels)

    def solve(self, now: Coordinates) -> None:
        """Leaves the state and its derivative in `run`, what is found of contacts in the parameters."""
        self.parameters, self.run = packed(self.scene)
        self.put(now)
        stand_in_space(self.parameters, self.run)
        self.dy = self.run.slopes[0]

    def put(self, now: Coordinates) -> None:
        y, at, axes = self.run.y, self.at, rotation(now.quaternion)
        arm = -axes @ self.origin
        y[POSITION : POSITION + 3] = now.position + arm
        y[ORIENTATION : ORIENTATION + 4] = now.quaternion
        y[at.velocity : at.velocity + 3] = now.velocity + cross(now.angular_velocity, arm)
        y[at.rate : at.rate + 3] = axes.T @ now.angular_velocity
        y[at.spin_angle : at.spin_angle + self.wheels] = now.spin_angle
        y[at.spin_rate : at.spin_rate + self.wheels] = now.spin_rate
        for place, (s, s_rate) in enumerate(self.joints(now)):
            y[at.joint + place], y[at.joint_rate + place] = s, s_rate
        for w, rates in enumerate(now.axial_rates):
            self.run.rates[w, : len(rates)] = rates
            if self.parameters.machine.every_rate:
                first = int(self.parameters.wheels[w].rates)
                y[first : first + len(rates)] = rates

    def joints(self, now: Coordinates) -> list[tuple[float, float]]:
        """Suspensions in the order of their wheels, then rockers."""
        hubs = [(now.travel[w], now.travel_rate[w]) for w in self.layout.hub]
        return [*hubs, *zip(now.axle_angle, now.axle_rate, strict=True)]

    def accelerations(self, now: Coordinates) -> dict[str, np.ndarray]:
        dy, at, axes = self.dy, self.at, rotation(now.quaternion)
        w, angular, arm = now.angular_velocity, axes @ dy[at.rate : at.rate + 3], axes @ self.origin
        linear = dy[at.velocity : at.velocity + 3] + cross(angular, arm) + cross(w, cross(w, arm))
        joints = dy[at.joint_rate : at.joint_rate + len(self.layout.hub) + len(now.axle_rate)]
        return {"acceleration": linear, "angular acceleration": angular, "carriers": joints,
                "spins": dy[at.spin_rate : at.spin_rate + self.wheels]}  # fmt: skip

    def contacts(self, now: Coordinates) -> dict[tuple[int, int, int], dict[str, np.ndarray | float]]:
        """By wheel, roller and piece of the ground: what is found, vectors in world axes."""
        found, bodies = {}, placed(self.layout, now)
        for w in range(self.wheels):
            axes, mode = self.mounted(w, now), self.run.mode[w]
            for c in range(int(mode.contacts)):
                seen, roller = self.parameters.space.touches[w * SLOTS + c], int(mode.roller[mode.slot[c]])
                normal = axes @ seen.normal
                h = cross(axes[:, 1], normal)
                h /= np.sqrt(h @ h)
                tangent = np.stack([h, cross(normal, h)])
                rate = roller if self.parameters.machine.every_rate else int(mode.slot[c])
                found[w, roller, int(mode.meeting[c])] = {
                    "point": bodies.x[self.layout.disk[w]] + axes @ seen.point,
                    "normal": normal,
                    "depth": seen.depth,
                    "load": seen.normal_force,
                    "slip": seen.slip @ tangent,
                    "friction": seen.force @ tangent,
                    "rolling": self.dy[int(self.parameters.wheels[w].rates) + rate],
                }
        return found

    def mounted(self, w: int, now: Coordinates) -> np.ndarray:
        """Columns h, k and z of what carries a wheel, world axes."""
        heading = np.radians(self.layout.wheels[w].entry.get("heading_deg", 0.0))
        own, axes = turned(np.array([0.0, 0.0, 1.0]), heading), rotation(now.quaternion)
        if w in self.layout.rocker:
            number = self.layout.rocker[w]
            axes = axes @ turned(self.layout.lines[number][1], now.axle_angle[number])
        return axes @ own

    def bearings(self, now: Coordinates) -> list[np.ndarray]:
        """Of each wheel (N + 1, 2, 3): force and moment of its axle along h, k, n, of its rollers along d, a x d, a."""
        loads = [np.zeros((2, 3, len(rates) + 1)) for rates in now.axial_rates]
        for w, (found, rates) in enumerate(zip(loads, now.axial_rates, strict=True)):
            recover_in_space(self.parameters, self.run.mode[w], w, self.run.y, self.dy, rates, found)
        return [found.transpose(2, 0, 1) for found in loads]


class Pairs(dict):
    """By quantity: what the oracle says and what the engine says."""

    def add(self, name, theirs, ours):
        self.setdefault(name, []).append((np.ravel(theirs), np.ravel(ours)))

    def difference(self, name):
        """The largest; relative, where there are values above 1."""
        theirs, ours = (np.concatenate([pair[side] for pair in self[name]]) for side in (0, 1))
        return np.abs(theirs - ours).max(initial=0.0) / max(np.abs(theirs).max(initial=0.0), 1.0)


def compare(pairs: Pairs, machine: Machine, engine: Engine, now: Coordinates) -> None:
    engine.solve(now)
    if any(wheel.entry["drive"]["kind"] == "dc_motor" for wheel in machine.wheels):
        machine.given_drives = np.array([part.drive_torque for part in engine.parameters.workspace.parts])
    found = machine.solve(0.0, now)
    add_accelerations(pairs, engine, now, found)
    add_contacts(pairs, engine, now, found)
    add_joints(pairs, engine, now, found)
    add_energy(pairs, machine, engine, now, found)


def add_accelerations(pairs: Pairs, engine: Engine, now: Coordinates, found: Reactions) -> None:
    ours = engine.accelerations(now)
    pairs.add("acceleration", found.acceleration, ours["acceleration"])
    pairs.add("angular acceleration", found.angular_acceleration, ours["angular acceleration"])
    pairs.add("spin acceleration", found.spin, ours["spins"])
    moved = [*(found.travel[w] for w in engine.layout.hub), *found.axle]
    pairs.add("acceleration of carriers", moved, ours["carriers"])


def add_contacts(pairs: Pairs, engine: Engine, now: Coordinates, found: Reactions) -> None:
    ours, theirs = engine.contacts(now), {(touch.wheel, touch.roller, touch.piece): touch for touch in found.touches}
    assert ours.keys() == theirs.keys()
    for which, touch in theirs.items():
        mine = ours[which]
        for name in ("point", "normal", "depth", "load", "slip", "friction"):
            pairs.add(name, getattr(touch, name), mine[name])
        kind = engine.layout.wheels[touch.wheel].kind  # its moment, as a force at the surface
        force = kind["roller"]["inertia_axial"] / (kind["radius"] - kind["roller_distance"])
        pairs.add("rolling", force * found.rollers[touch.wheel][touch.roller], force * mine["rolling"])


def add_joints(pairs: Pairs, engine: Engine, now: Coordinates, found: Reactions) -> None:
    """Moments as forces at a lever of the wheel's radius, so that none is small beside 1."""
    layout, bodies = engine.layout, placed(engine.layout, now)
    for w, ours in enumerate(engine.bearings(now)):
        scale, hub = 1.0 / layout.wheels[w].kind["radius"], bodies.x[layout.disk[w]]
        out = bodies.x[layout.rollers[w]] - hub
        a, k = bodies.axis[layout.rollers[w]], bodies.axis[layout.disk[w]]
        d = out - (out @ k)[:, None] * k
        d /= np.linalg.norm(d, axis=1)[:, None]
        frames = np.stack([engine.mounted(w, now).T, *np.stack([d, cross(a, d), a], axis=1)])
        held = found.joints[[layout.disk[w], *range(layout.rollers[w].start, layout.rollers[w].stop)]]
        theirs = np.einsum("bij,bkj->bki", frames, held.reshape(-1, 2, 3))
        pairs.add("forces of axles", theirs[0, 0], ours[0, 0])
        pairs.add("moments of axles", scale * theirs[0, 1], scale * ours[0, 1])
        pairs.add("forces of roller axles", theirs[1:, 0], ours[1:, 0])
        pairs.add("moments of roller axles", scale * theirs[1:, 1], scale * ours[1:, 1])


def add_energy(pairs: Pairs, machine: Machine, engine: Engine, now: Coordinates, found: Reactions) -> None:
    told, parameters, run = energy(machine, 0.0, now, found), engine.parameters, engine.run
    pairs.add("kinetic energy", told.kinetic, motion_energy(parameters, run.y, padded(now, run.rates.shape)))
    pairs.add("stored energy", told.gravity + told.elastic, stored_energy(parameters, run.mode, run.y))
    for name, theirs in LOSSES.items():
        modelled = {"bearing_loss": parameters.machine.bearing_friction, "rolling_loss": parameters.machine.rolling}
        if modelled.get(name, True):
            pairs.add("powers", getattr(told, theirs), engine.dy[getattr(engine.at, name)])


def padded(now: Coordinates, shape: tuple[int, int]) -> np.ndarray:
    rates = np.zeros(shape)
    for own, values in zip(rates, now.axial_rates, strict=True):
        own[: len(values)] = values
    return rates


@pytest.fixture(scope="module", params=[FEW, pytest.param(MANY, marks=pytest.mark.long)], ids=["few", "many"])
def count(request):
    return request.param


@pytest.fixture(
    scope="module", params=[pytest.param(name, marks=[pytest.mark.long] * (name in SLOW)) for name in SMOOTH]
)
def pairs(request, count, tmp_path_factory):
    folder, pairs = tmp_path_factory.mktemp("scene"), Pairs()
    np.save(folder / GRID["file"], heights())
    (folder / "scene.toml").write_text(tomlkit.dumps(SCENES[request.param]))
    machine = Machine(SCENES[request.param], folder)
    engine = Engine(omnisim.load(folder / "scene.toml", ["initial.height=0.1"]), machine.layout)  # above the ground
    for now in states(machine, count, count):
        if carried(machine, now):
            compare(pairs, machine, engine, now)
    return pairs


def carried(machine: Machine, now: Coordinates) -> bool:
    """Whether viscous friction, which knows no N, has one at every contact: see the last test."""
    touches = machine.touches(placed(machine.layout, now))
    return machine.friction["law"] != "viscous" or all(touch.load > 0.0 for touch in touches)


def assert_equal(pairs: Pairs, bounds: dict[str, float]) -> None:
    found = {name: pairs.difference(name) for name in bounds}
    assert all(found[name] < bound for name, bound in bounds.items()), found


def test_rollers_touch_where_the_common_normals_are(pairs):
    assert_equal(pairs, dict.fromkeys(("point", "normal", "depth"), 1e-13))  # measured: 4e-15


def test_the_ground_pushes_and_rubs_alike(pairs):
    assert_equal(pairs, dict.fromkeys(("load", "slip", "friction"), 1e-10))  # measured: 3e-13


def test_accelerations_are_those_of_the_free_bodies(pairs):
    names = ("acceleration", "angular acceleration", "spin acceleration", "acceleration of carriers")
    assert_equal(pairs, dict.fromkeys((*names, "rolling"), 1e-10))  # measured: 4e-13


def test_axles_carry_the_multipliers_of_their_joints(pairs):
    names = (f"{name} of {axles}" for name in ("forces", "moments") for axles in ("axles", "roller axles"))
    assert_equal(pairs, dict.fromkeys(names, 1e-10))


def test_energies_and_powers_are_the_sums_over_all_bodies(pairs):
    assert_equal(pairs, dict.fromkeys(("kinetic energy", "stored energy", "powers"), 1e-11))  # measured: 2e-13


def test_fast_slip_is_saturated_from_the_start():
    scene = changed("kiwi_slope", friction={"law": "saturated"})
    machine, pairs = Machine(scene), Pairs()
    engine = Engine(parse(tomlkit.dumps(scene)), machine.layout)
    for now in states(machine, 5, 5):
        compare(pairs, machine, engine, now)
    assert_equal(pairs, {"friction": 1e-10})


def test_nothing_rubs_without_a_load():
    """Rubber that is slower than the roller leaves it: N = 0 while delta > 0."""
    machine, pairs = Machine(SCENES["viscous"]), Pairs()
    engine = Engine(parse(tomlkit.dumps(SCENES["viscous"])), machine.layout)
    for now in states(machine, FEW, 2 * FEW):
        if not carried(machine, now):
            compare(pairs, machine, engine, now)
    assert_equal(pairs, {"friction": 1e-10})
