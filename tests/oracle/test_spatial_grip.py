"""Contacts of machines free in space that stick or creep, against the oracle: what their forces do, and that they hold.

The engine finds the forces; the oracle is given them, and must find the same accelerations and the same loads of
every bearing. The slip, differenced along the motion that follows, must not change where a contact sticks, and change
along itself where it creeps. In closed form it changes as these differences say, on curved ground too.
"""

import numpy as np
import pytest
import tomlkit
from helpers.stages import either
from machines import run
from scenes import of_wheels

import omnisim
from omnisim.contact.set_valued import CREEP, SLIP, STICK
from omnisim.dynamics.spatial.acceleration import slip_at, slip_change
from omnisim.dynamics.spatial.held import factorize_firm
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import standing, touching_at
from omnisim.march.runge_kutta import refresh
from omnisim.scene.scene import parse
from oracle.spatial.bodies import Coordinates, rotation, turned
from oracle.spatial.machine import Machine
from oracle.spatial.states import GRID, SCENES, heights, states
from oracle.test_spatial import Engine, Pairs, add_accelerations, add_energy, add_joints, assert_equal
from oracle.vectors import cross

CASES = ("kiwi_slope", "mecanum_springs", "double_row")
LOADS = tuple(f"{name} of {axles}" for name in ("forces", "moments") for axles in ("axles", "roller axles"))
FEW = 6
CURVED = ("kiwi_slope", "mecanum_bump", "shapes on bumps", "grid", "kerb", "ribs", "rockers")
MOMENT = 2e-6  # s, of differences of slip


def gripping(name: str) -> dict:
    """A scene of the oracle with set-valued friction."""
    scene = tomlkit.parse(tomlkit.dumps(SCENES[name])).unwrap()
    scene["friction"] = {"law": "coulomb", "coefficient": scene["friction"]["coefficient"]}
    return scene


def hold(engine: Engine, now) -> None:
    """Let the only contact of every wheel stick or, of every other wheel, creep, and find the forces."""
    engine.solve(now)
    for w in range(engine.wheels):
        mode = engine.run.mode[w]
        if mode.contacts == 1 and mode.pressed[0]:
            mode.grip[0], mode.creep[0] = CREEP if w % 2 else STICK, 0.0
    refresh(engine.parameters, engine.run, 0.0)


def change_of_slip(engine: Engine, w: int, c: int = 0) -> np.ndarray:
    """v' at a contact of wheel w along the motion, by differences of fourth order, m/s^2."""
    parameters, run = engine.parameters, engine.run
    at = [np.array(slip_at(parameters, run.mode[w], w, c, run.y + k * MOMENT * run.slopes[0])) for k in (-2, -1, 1, 2)]
    return (at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3]) / (12.0 * MOMENT)


@pytest.mark.parametrize("name", either(CURVED, ["mecanum_bump", "kerb"]))
def test_slip_changes_in_closed_form_as_it_does_along_the_motion(name, tmp_path):
    """Where the ground turns below a contact as well: on a bump, in a grid of heights, around the edge of a step."""
    np.save(tmp_path / GRID["file"], heights())
    (tmp_path / "scene.toml").write_text(tomlkit.dumps(SCENES[name]))
    machine = Machine(SCENES[name], tmp_path)
    engine = Engine(omnisim.load(tmp_path / "scene.toml", ["initial.height=0.1"]), machine.layout)
    apart, largest = [], 0.0
    for now in states(machine, 7, FEW):
        engine.solve(now)
        parameters, run = engine.parameters, engine.run
        for w in range(engine.wheels):
            for c in range(run.mode[w].contacts):
                stand = standing(parameters, w, body_of(parameters, run.y), run.y)
                place = stand, touching_at(parameters, run.mode[w], w, c, stand)
                change = slip_change(parameters, run.mode[w], w, c, place, run.y, run.slopes[0])
                differenced = change_of_slip(engine, w, c)
                apart.append(np.abs(np.array(change) - differenced).max())
                largest = max(largest, np.abs(differenced).max())
    assert len(apart) > FEW and max(apart) < 1e-9 * largest, (max(apart), largest)  # measured: 5e-11


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_forces_of_contacts_at_rest_do_what_the_oracle_says(name):
    scene = gripping(name)
    machine, pairs = Machine(scene), Pairs()
    engine = Engine(parse(tomlkit.dumps(scene)), machine.layout)
    held = 0
    for now in states(machine, 7, FEW):
        hold(engine, now)
        for (w, roller, piece), found in engine.contacts(now).items():
            machine.given_friction[w, roller, piece] = found["friction"]
            held += engine.run.mode[w].grip[0] == STICK
        reactions = machine.solve(0.0, now)
        add_accelerations(pairs, engine, now, reactions)
        add_joints(pairs, engine, now, reactions)
        add_energy(pairs, machine, engine, now, reactions)
        machine.given_friction.clear()
    assert held >= FEW
    assert_equal(pairs, {"acceleration": 1e-10, "angular acceleration": 1e-10, "spin acceleration": 1e-10})
    assert_equal(pairs, dict.fromkeys(LOADS, 1e-10))  # measured: 1e-13


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_slip_that_sticks_does_not_change_and_slip_that_creeps_changes_along_itself(name):
    scene = gripping(name)
    machine = Machine(scene)
    engine = Engine(parse(tomlkit.dumps(scene)), machine.layout)
    largest = {STICK: [], CREEP: []}  # m/s^2, of slip accelerations that are some 10 without these forces
    for now in states(machine, 7, FEW):
        hold(engine, now)
        rest = sum(int(np.count_nonzero(mode.grip[: mode.contacts] != SLIP)) for mode in engine.run.mode)
        assert factorize_firm(engine.parameters.space.holding, rest).added == 0.0, "there is one way to hold them"
        for w in range(engine.wheels):
            grip, touch = engine.run.mode[w].grip[0], engine.parameters.space.touches[w * SLOTS]
            change = change_of_slip(engine, w)
            if grip == STICK:
                largest[STICK].append(np.abs(change).max())
            elif grip == CREEP:
                u = touch.creep
                largest[CREEP].append(abs(change[0] * u[1] - change[1] * u[0]))
                assert abs(np.hypot(*touch.force) - scene["friction"]["coefficient"] * touch.normal_force) < 1e-12
    assert min(len(found) for found in largest.values()) > 1
    assert max(map(max, largest.values())) < 1e-6, {grip: max(found) for grip, found in largest.items()}


def told(motion, row: int) -> Coordinates:
    """A row of a trajectory of a machine whose wheels are fixed to the chassis."""
    body = [motion[f"body/{name}"][row] for name in ("position", "orientation", "velocity", "angular_velocity")]
    spins, rates = (of_wheels(motion, name)[row] for name in ("spin_angle", "spin_rate"))
    none, rollers = np.zeros(len(spins)), list(of_wheels(motion, "rollers/axial_rate")[row])
    return Coordinates(*body, spins, rates, none, none, none[:0], none[:0], rollers)


def friction_told(machine: Machine, motion, row: int, now: Coordinates) -> None:
    """Give the oracle the friction of the file, along the heading in the tangent plane and across."""
    normal, axes = np.array([0.0, 0.0, 1.0]), rotation(now.quaternion)
    for w, name in enumerate(motion.wheels):
        heading = np.radians(machine.wheels[w].entry.get("heading_deg", 0.0))
        h = cross((axes @ turned(normal, heading))[:, 1], normal)
        h /= np.sqrt(h @ h)
        force = motion[f"wheels/{name}/friction_force"][row] @ np.stack([h, cross(normal, h)])
        machine.given_friction[w, int(motion[f"wheels/{name}/contact_roller"][row]), 0] = force


@pytest.mark.long
def test_bearing_loads_of_a_run_through_sticks_and_slips_are_the_multipliers_of_the_joints():
    """The size of each in the file, in all rows in which every wheel stands on one roller."""
    scene = gripping("kiwi_slope") | {"time": {"end": 0.2, "step": 1e-4, "output_interval": 4e-3}}
    machine, motion = Machine(scene), run(scene | {"output": {"bearing_loads": True}})
    alone = np.flatnonzero(np.all(of_wheels(motion, "contact_share") == 1.0, axis=1))
    stuck = np.linalg.norm(of_wheels(motion, "slip_velocity")[alone], axis=2) < 1e-9
    assert stuck.any(axis=0).all() and (~stuck).any(axis=0).all(), "each wheel sticks in some rows and slips in others"
    apart = {"force": 0.0, "moment": 0.0}
    for row in alone:
        now = told(motion, row)
        friction_told(machine, motion, row, now)
        held, layout = machine.solve(float(motion.time[row]), now).joints, machine.layout
        machine.given_friction.clear()
        for w, name in enumerate(motion.wheels):
            for k, part in enumerate(apart):
                axle = motion[f"wheels/{name}/bearing_{part}"][row]
                theirs = np.linalg.norm(held[layout.disk[w], 3 * k : 3 * k + 3])
                apart[part] = max(apart[part], abs(np.linalg.norm(axle) - theirs))
                own = np.linalg.norm(motion[f"wheels/{name}/rollers/bearing_{part}"][row], axis=1)
                theirs = np.linalg.norm(held[layout.rollers[w], 3 * k : 3 * k + 3], axis=1)
                apart[part] = max(apart[part], np.abs(own - theirs).max())
    assert apart["force"] < 1e-9 and apart["moment"] < 1e-10, apart  # N, N m; measured 4.6e-12, 8.4e-14
