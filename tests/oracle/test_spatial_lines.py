"""Wheels at rest on the lines of their rollers, loaded askew: the forces that hold one, against least squares.

Every roller that lies on a line touches twice and is held along the line once. Free bodies and joints tell how each
friction force accelerates the material at every contact; the forces that leave it at rest are found by least squares.
They are not unique, what they do is.
"""

import numpy as np
import pytest
import tomlkit

from omnisim.contact.set_valued import SLIP, STICK
from omnisim.dynamics.spatial.held import factorize_firm
from omnisim.march.runge_kutta import refresh
from omnisim.scene.scene import parse
from oracle.spatial.bodies import Coordinates, placed
from oracle.spatial.machine import Machine
from oracle.spatial.states import changed
from oracle.test_spatial import Engine, Pairs, add_accelerations, assert_equal
from oracle.vectors import cross

CYLINDER = {"kind": "cylinder", "radius": 0.008, "half_length": 0.012, "edge_radius": 0.001}
TILTS = ((0.0, 0.0, 0.0), (4e-4, -3e-4, 5e-4), (-1e-4, 6e-4, 2e-4))  # rad, of each wheel about its axle
KEPT = 1e-9  # of the largest singular value: what is left below is rounding
FRICTION = 5.0  # holds it however it is accelerated


def on_lines() -> dict:
    """Three wheels on cylinders, whose centre of mass is aside, on a slope of 2 deg."""
    scene = changed("kiwi_slope", floor={"slope_deg": 2.0}, friction={"law": "coulomb", "coefficient": FRICTION})
    scene["friction"].pop("slip_speed", None)
    scene["wheel_types"]["type0"]["profile"] = CYLINDER
    scene["chassis"]["center_of_mass"] = [0.02, 0.01, 0.1]
    for key in ("wrench", "command"):
        scene.pop(key, None)
    for wheel in scene["wheels"]:
        for key in ("spin_rate", "spin_angle_deg", "phase_deg", "roller_rates"):
            wheel.pop(key, None)
        wheel["drive"] = {"kind": "torque", "torque": 0.01}
    return scene


def at_rest(machine: Machine, tilt: tuple) -> Coordinates:
    """0.1 mm deep in its rubber, nothing moves."""
    none, rollers = np.zeros(3), [np.zeros(wheel.count) for wheel in machine.wheels]
    level = np.array([1.0, 1e-4, -2e-4, 0.0])
    level /= np.sqrt(level @ level)
    place = np.array([0.1, -0.2, -1e-4])
    empty = none[:0]
    return Coordinates(place, level, none, none, np.array(tilt), none, none, none, empty, empty, rollers)


def slip_changes(machine: Machine, now: Coordinates, w: int) -> np.ndarray:
    """Along x and y of the ground at the contacts of wheel w (4,), m/s^2."""
    found, bodies = machine.solve(0.0, now), placed(machine.layout, now)
    rates = []
    for touch in found.touches:
        if touch.wheel == w:
            body = machine.layout.rollers[w].start + touch.roller
            moved = found.bodies[body, :3] + cross(found.bodies[body, 3:], touch.point - bodies.x[body])
            rates.append(moved[:2])
    return np.ravel(rates)


def hold(machine: Machine, now: Coordinates, names: list) -> np.ndarray:
    """Give the machine the least friction at these contacts of one wheel that leaves them at rest, by names (wheel,
    roller, piece): the singular values of what forces do."""
    w = names[0][0]
    bias, columns = slip_changes(machine, now, w), []
    for name in names:
        for unit in np.eye(3)[:2]:
            machine.given_friction[name] = unit
            columns.append(slip_changes(machine, now, w) - bias)
        machine.given_friction[name] = np.zeros(3)
    response = np.stack(columns, axis=1)
    forces = np.linalg.lstsq(response, -bias, rcond=KEPT)[0].reshape(-1, 2)
    for name, force in zip(names, forces, strict=True):
        machine.given_friction[name] = np.append(force, 0.0)
    return np.linalg.svd(response, compute_uv=False)


@pytest.mark.long
@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("w", range(3))
def test_what_holds_a_wheel_on_a_line_is_what_least_squares_find(tilt, w):
    """The other wheels slip without friction."""
    scene = on_lines()
    machine, pairs = Machine(scene), Pairs()
    engine, now = Engine(parse(tomlkit.dumps(scene)), machine.layout), at_rest(machine, tilt)
    engine.solve(now)
    for v, mode in enumerate(engine.run.mode):
        assert mode.contacts == 2
        mode.grip[:2] = STICK if v == w else SLIP
    refresh(engine.parameters, engine.run, 0.0)
    assert factorize_firm(engine.parameters.space.holding, 2).added > 0.0, "it can be held in more than one way"
    found = engine.contacts(now)
    machine.given_friction = dict.fromkeys(found, np.zeros(3))
    values = hold(machine, now, [name for name in found if name[0] == w])
    assert values[3] < KEPT * values[0] < values[2], "two ends are held in three ways"
    assert np.abs(slip_changes(machine, now, w)).max() < 1e-11  # m/s^2
    reactions = machine.solve(0.0, now)
    add_accelerations(pairs, engine, now, reactions)
    assert_equal(pairs, {"acceleration": 1e-10, "angular acceleration": 1e-10, "spin acceleration": 1e-10})
    assert parted(machine, now, w, [seen for name, seen in engine.contacts(now).items() if name[0] == w]) < 1e-9


def parted(machine: Machine, now: Coordinates, w: int, ends: list) -> float:
    """By how much the parts differ which the force along the line has of what the cones of its ends leave for it."""
    assert abs(ends[0]["load"] - ends[1]["load"]) > 0.01 * ends[0]["load"], "it is loaded askew"
    axis = placed(machine.layout, now).axis[machine.layout.rollers[w].start]
    line = np.array([axis[0], axis[1], 0.0]) / np.hypot(axis[0], axis[1])
    along = np.array([end["friction"] @ line for end in ends])
    across = np.array([end["friction"] @ end["friction"] for end in ends]) - along**2
    parts = along / np.sqrt((FRICTION * np.array([end["load"] for end in ends])) ** 2 - across)
    assert abs(parts[0]) > 1e-4
    return abs(parts[0] - parts[1]) / abs(parts[0])
