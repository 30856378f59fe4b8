"""Scenes and states in which every term of the equations of a machine free in space is at work.

A scene is the plain dictionary of a scene file. `states` puts its machine anywhere on the ground, all rates unequal 0:
standing, every wheel up to 0.3 mm into its rubber or just above the ground as far as three heights and the springs
allow that; or leaning on one.
"""

import json
import tomllib
from collections.abc import Callable, Iterator
from copy import deepcopy
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from oracle.spatial.bodies import Bodies, Coordinates, X, Y, Z, placed
from oracle.spatial.machine import Machine, Touch
from oracle.spatial.motion import half, multiplied

REFERENCE = Path(__file__).parents[2] / "reference"
REFERENCES = ("kiwi_slope", "mecanum_bump", "mecanum_springs", "double_row")
LEANS = (0.0, 0.0, 0.05, 0.0, 0.4)  # rad, in turn; 0: standing
DEEPEST, HIGHEST = 3e-4, -5e-5  # m


def load(name: str) -> tuple[dict, dict]:
    """A reference scene, and its motion."""
    path = REFERENCE / f"spatial_{name}"
    return tomllib.loads(path.with_suffix(".toml").read_text()), json.loads(path.with_suffix(".json").read_text())


def changed(name: str, **tables: dict) -> dict:
    """A reference scene with these keys of its tables."""
    scene = deepcopy(load(name)[0])
    for table, keys in tables.items():
        scene[table] = scene.get(table, {}) | keys
    return scene


def unlike() -> dict:
    """Four unlike wheels over a bump and a pit on a slope: two of them on springs, one with two rows that do not
    balance, one of barrels; bearings with friction; rotors of motors; a body wrench that changes."""
    pushed = {"frame": "body", "times": [0.0, 0.5], "force": [[3.0, -4.0, 2.0], [1.0, 5.0, -3.0]]}
    scene = changed(
        "mecanum_springs",
        floor={"slope_deg": 12.0, "uphill_deg": 130.0, "bumps": [[0.2, 0.1, 0.02, 0.2], [-0.3, -0.1, -0.015, 0.25]]},
        chassis={"center_of_mass": [0.03, -0.02, 0.14], "inertia": [0.4, 0.6, 0.9]},
        wrench=pushed | {"yaw_torque": [0.7, -0.4]},
    )
    base = scene["wheel_types"]["type0"]
    rough = base["roller"] | {"bearing_viscosity": 1e-5, "bearing_torque": 2e-3, "bearing_rate": 5.0}
    rows = [{"offset": -0.004, "phase_deg": 3.0}, {"offset": 0.011, "phase_deg": 20.0}]
    scene["wheel_types"] |= {
        "rough": base | {"roller": rough, "roller_count": 8, "roller_angle_deg": 30.0},
        "rows": base | {"rows": rows, "roller": rough, "covered_deg": 26.0, "roller_angle_deg": 20.0},
        "barrels": base | {"profile": {"kind": "arc", "radius": 0.011, "curvature_radius": 0.05, "half_length": 0.02}},
    }
    kinds, headings = ("type0", "rough", "rows", "barrels"), (3.0, -5.0, 20.0, 184.0)
    for wheel, kind, heading in zip(scene["wheels"], kinds, headings, strict=True):
        wheel |= {"type": kind, "heading_deg": heading}
    del scene["wheels"][1]["suspension"], scene["wheels"][3]["suspension"]
    motor = {"kind": "dc_motor", "voltage": 6.0, "resistance": 1.2, "torque_constant": 0.02, "gear_ratio": 12.0}
    scene["wheels"][0]["drive"] = scene["wheels"][1]["drive"] = motor | {"rotor_inertia": 4e-6}
    scene["wheels"][2]["suspension"] = {"mass": 0.5, "inertia": 3e-4, "stiffness": 6000.0, "damping": 80.0}
    return scene


def resisting(name: str, **tables: dict) -> dict:
    """A reference scene whose rollers resist rolling, by more than rubber does."""
    scene = changed(name, **tables)
    for kind in scene["wheel_types"].values():
        kind["roller"] = kind["roller"] | {"rolling_resistance": 2e-3, "rolling_rate": 2.0}
    return scene


def machine_of(scene: dict) -> Machine:
    """With torques of its motors, if there are any, that no law gives, and the heights of its grid."""
    with TemporaryDirectory() as folder:
        np.save(Path(folder) / GRID["file"], heights())
        machine = Machine(scene, Path(folder))
    if any(wheel.entry["drive"]["kind"] == "dc_motor" for wheel in machine.wheels):
        machine.given_drives = np.linspace(-0.4, 0.3, len(machine.wheels))
    return machine


def shaped(name: str, *profiles: dict, **tables: dict) -> dict:
    """A reference machine whose wheels have rollers of these profiles in turn."""
    scene = changed(name, **tables)
    base = scene["wheel_types"]["type0"]
    scene["wheel_types"] = {f"type{number}": base | {"profile": profile} for number, profile in enumerate(profiles)}
    for number, wheel in enumerate(scene["wheels"]):
        wheel["type"] = f"type{number % len(profiles)}"
    return scene


def rockers() -> dict:
    """A mecanum machine on a bump whose rear wheels share a rocker about x, its front wheels one about y."""
    scene = changed("mecanum_bump", floor={"slope_deg": 5.0, "uphill_deg": -60.0})
    scene["axles"] = [
        {"name": "rear", "wheels": ["rl", "rr"], "about": "x", "point": [-0.2, 0.01, 0.06]},
        {"name": "front", "wheels": ["fl", "fr"], "about": "y", "point": [0.2, 0.0, 0.08]},
    ]
    return scene


def many_rollers() -> dict:
    """A kiwi on bumps with 24 rollers to a wheel, in two rows of twelve."""
    scene = changed("kiwi_slope", floor={"bumps": [[0.05, 0.1, 0.01, 0.12], [-0.1, -0.05, 0.006, 0.1]]})
    rows = [{"offset": -0.006}, {"offset": 0.006, "phase_deg": 15.0}]
    scene["wheel_types"]["type0"] |= {"roller_count": 12, "rows": rows}
    return scene


def ribs() -> dict:
    """A kiwi across parallel steps up and down, with edges of all sizes, some without a face."""
    shapes = [(0.004, 0.002), (-0.004, 0.003), (0.006, 0.004), (-0.006, 0.005), (0.003, 0.001), (-0.003, 0.03)]
    places = [0.07 * number - 0.21 for number in range(6)]
    rows = [(place, *shapes[number]) for number, place in enumerate(places)]
    steps = [
        {"point": [s, 0.3 * s], "direction_deg": 20.0, "height": height, "edge_radius": e} for s, height, e in rows
    ]
    return changed("kiwi_slope", floor={"steps": steps})


def kerb() -> dict:
    """A kiwi before a step higher than its rollers are thick."""
    step = {"point": [0.65, 0.0], "direction_deg": 10.0, "height": 0.024, "edge_radius": 0.003}
    return changed("kiwi_slope", floor={"steps": [step]})


def heights() -> np.ndarray:
    """Of a grid, rows along x."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 7))
    return 0.004 * np.sin(5.0 * x + 1.0) * np.cos(4.0 * y) + 0.002 * x


def grid() -> dict:
    """A mecanum machine on a grid of heights, which end within its reach."""
    return changed("mecanum_bump", floor={"bumps": [], "grid": GRID})


BRUSH = {"law": "brush", "slip_speed": 0.01, "creep_stiffness": 6.0}
GRID = {"file": "heights.npy", "origin": [-0.5, -0.4], "spacing": [0.12, 0.14]}
SCENES = {name: load(name)[0] for name in REFERENCES}
LONG = [
    {"kind": "cylinder", "radius": 0.0112, "half_length": 0.02, "edge_radius": 0.003},
    {"kind": "stepped", "radii": [0.0115, 0.0105, 0.008], "lengths": [0.009, 0.008, 0.006]},
    {"kind": "cone", "radius": 0.0115, "end_radius": 0.007, "half_length": 0.022},
    {"kind": "points", "axial": [-0.024, -0.017, -0.008, 0.001, 0.01, 0.016, 0.022],
     "radius": [0.0065, 0.0092, 0.0111, 0.0115, 0.0108, 0.0094, 0.0072]},
]  # fmt: skip
SHORT = [
    {"kind": "capsule", "radius": 0.0078, "half_length": 0.014},
    {"kind": "cylinder", "radius": 0.008, "half_length": 0.012},
    {"kind": "sphere", "radius": 0.0085},
]
SCENES |= {
    "long shapes": shaped("mecanum_bump", *LONG, floor={"bumps": [], "slope_deg": 8.0}),
    "short shapes": shaped("kiwi_slope", *SHORT),
    "shapes on bumps": shaped("mecanum_bump", *LONG),
    "viscous": changed("mecanum_bump", friction={"law": "viscous", "viscosity": 30.0}),
    "coulomb": changed("kiwi_slope", friction={"law": "coulomb"}),
    "brush": changed("kiwi_slope", friction=BRUSH),
    "brush on springs": changed("mecanum_springs", friction=BRUSH),
    "brush on a bump": changed("mecanum_bump", friction=BRUSH),
    "brush of two rows": changed("double_row", friction=BRUSH),
    "brush of several lobes": shaped("mecanum_springs", *LONG, friction=BRUSH),
    "no friction": changed("double_row", friction={"law": "none"}),
    "rolling resistance": resisting("kiwi_slope"),
    "rolling resistance on springs": resisting("mecanum_springs", friction=BRUSH),
    "rolling resistance on a bump": resisting("mecanum_bump"),
    "unlike wheels": unlike(),
    "24 rollers": many_rollers(),
    "rockers": rockers(),
    "ribs": ribs(),
    "kerb": kerb(),
    "grid": grid(),
}


def states(machine: Machine, seed: int, count: int) -> Iterator[Coordinates]:
    """So many states, standing and leaning."""
    random = np.random.default_rng(seed)
    for number in range(count):
        lean = LEANS[number % len(LEANS)]
        now = anywhere(machine, random, lean)
        if machine.ground.steps:
            now = dropped(machine, now, random.uniform(0.1, 1.0) * DEEPEST)
            yield now if lean else pushed(machine, now, random.uniform(0.1, 1.0) * DEEPEST)
        elif lean:
            yield lowered(machine, now, random.uniform(0.1, 1.0) * DEEPEST)
        else:
            yield stood(machine, now, random.uniform(HIGHEST, DEEPEST, len(machine.wheels)))


def anywhere(machine: Machine, random: np.random.Generator, lean: float) -> Coordinates:
    wheels, rockers = len(machine.wheels), len(machine.layout.carriers)
    towards, yaw = random.uniform(-pi, pi, 2)
    for step in machine.ground.steps[:1]:  # wheels across and along it
        yaw = np.arctan2(step.up[1], step.up[0]) + random.integers(6) * pi / 3.0 + 0.03 * yaw
    tilt = half(np.cos(towards) * X + np.sin(towards) * Y, lean)
    sprung = np.array([w in machine.layout.hub for w in range(wheels)], dtype=float)
    return Coordinates(
        position=np.array([*random.uniform(-0.3, 0.3, 2), 0.0]),
        quaternion=multiplied(tilt, half(Z, yaw)),
        velocity=random.uniform(-1.0, 1.0, 3) * [0.5, 0.5, 0.2],
        angular_velocity=random.uniform(-1.0, 1.0, 3) * [0.2, 0.2, 1.5],
        spin_angle=random.uniform(-pi, pi, wheels),
        spin_rate=random.uniform(-8.0, 8.0, wheels),
        travel=sprung * random.uniform(-1e-3, 1e-3, wheels),
        travel_rate=sprung * random.uniform(-0.05, 0.05, wheels),
        axle_angle=random.uniform(-1.0, 1.0, rockers) * max(lean, 2e-3),
        axle_rate=random.uniform(-0.3, 0.3, rockers),
        axial_rates=[random.uniform(-20.0, 20.0, wheel.count) for wheel in machine.wheels],
    )


def depths(machine: Machine, now: Coordinates) -> tuple[np.ndarray, Bodies]:
    """How deep the deepest roller of every wheel is in the ground, m, < 0 above it."""
    bodies, deepest = placed(machine.layout, now), []
    for wheel, rollers in zip(machine.wheels, machine.layout.rollers, strict=True):
        pairs = list(zip(bodies.x[rollers], bodies.axis[rollers], strict=True))
        pairs.sort(key=lambda pair: wheel.lowest(*pair, Z)[2])
        deepest.append(
            max(part.meet(x, axis, machine.ground, x[:2]).depth for x, axis in pairs[:3] for part in wheel.parts)
        )
    return np.array(deepest), bodies


def lowered(machine: Machine, now: Coordinates, depth: float) -> Coordinates:
    """The same state lifted or lowered until its deepest contact is so deep."""
    for _ in range(8):
        now = now._replace(position=now.position + (depths(machine, now)[0].max() - depth) * Z)
    return now


def dropped(machine: Machine, now: Coordinates, depth: float) -> Coordinates:
    """The same state let down until a contact with ground or an edge is so deep."""
    return moved_until(machine, now._replace(position=now.position + 0.1 * Z), -Z, lambda touch: touch.depth > depth)


def pushed(machine: Machine, now: Coordinates, depth: float) -> Coordinates:
    """The same state pushed towards the first step until a contact with an edge is so deep."""
    up = machine.ground.steps[0].up
    return moved_until(machine, now, up, lambda touch: touch.piece > 0 and touch.depth > depth)


def moved_until(
    machine: Machine, now: Coordinates, way: np.ndarray, done: Callable[[Touch], bool], stride: float = 8e-3
) -> Coordinates:
    """The same state moved along a way as far as some contact says, or not at all if none does within 0.8 m."""
    first, halvings = now, 0
    for _ in range(120):
        there = now._replace(position=now.position + stride * way)
        if not any(map(done, machine.touches(placed(machine.layout, there)))):
            now = there
            continue
        stride, halvings = 0.5 * stride, halvings + 1
        if halvings == 13:
            return there
    return first


def stood(machine: Machine, now: Coordinates, wanted: np.ndarray) -> Coordinates:
    """The same state, lifted, tilted and its springs set so that the wheels come near to these depths."""
    sprung = np.array([w in machine.layout.hub for w in range(len(wanted))], dtype=float)
    for _ in range(8):
        found, bodies = depths(machine, now)
        arm = bodies.x[machine.layout.disk] - now.position
        rise = np.column_stack([np.ones(len(wanted)), arm[:, 1], -arm[:, 0], np.diag(sprung)])
        lift, *tilt = (step := np.linalg.lstsq(rise, found - wanted)[0])[:3]
        now = now._replace(
            position=now.position + lift * Z,
            quaternion=multiplied(half(X, tilt[0]), multiplied(half(Y, tilt[1]), now.quaternion)),
            travel=now.travel + step[3:],
        )
    return now
