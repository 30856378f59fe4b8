"""Contacts of machines free in space that stick or creep, against the oracle: what their forces do, and that they hold.

The engine finds the forces; the oracle is given them, and must find the same accelerations. The slip, differenced along
the motion that follows, must not change where a contact sticks, and change along itself where it creeps.
"""

import numpy as np
import pytest
import tomlkit

from omnisim.contact.set_valued import CREEP, STICK
from omnisim.dynamics.spatial.acceleration import slip_change_on_ground
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import standing
from omnisim.march.runge_kutta import refresh
from omnisim.scene.scene import parse
from oracle.spatial.machine import Machine
from oracle.spatial.states import states
from oracle.test_spatial import SCENES, Engine, Pairs, add_accelerations, add_energy, assert_equal

CASES = ("kiwi_slope", "mecanum_springs", "double_row")
FEW = 6


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


def change_of_slip(engine: Engine, w: int) -> np.ndarray:
    """v' at the contact of wheel w along the motion, by differences, m/s^2."""
    parameters, run = engine.parameters, engine.run
    stand = standing(parameters, w, body_of(parameters, run.y), run.y)
    return np.array(slip_change_on_ground(parameters, run.mode[w], w, 0, stand, run.y, run.slopes[0]))


@pytest.mark.parametrize("name", CASES)
def test_forces_of_contacts_at_rest_do_what_the_oracle_says(name):
    scene = gripping(name)
    machine, pairs = Machine(scene), Pairs()
    engine = Engine(parse(tomlkit.dumps(scene)), machine.layout)
    held = 0
    for now in states(machine, 7, FEW):
        hold(engine, now)
        for (w, roller, _), found in engine.contacts(now).items():
            machine.given_friction[w, roller] = found["friction"]
            held += engine.run.mode[w].grip[0] == STICK
        reactions = machine.solve(0.0, now)
        add_accelerations(pairs, engine, now, reactions)
        add_energy(pairs, machine, engine, now, reactions)
        machine.given_friction.clear()
    assert held >= FEW
    assert_equal(pairs, {"acceleration": 1e-10, "angular acceleration": 1e-10, "spin acceleration": 1e-10})


@pytest.mark.parametrize("name", CASES)
def test_slip_that_sticks_does_not_change_and_slip_that_creeps_changes_along_itself(name):
    scene = gripping(name)
    machine = Machine(scene)
    engine = Engine(parse(tomlkit.dumps(scene)), machine.layout)
    largest = {STICK: [], CREEP: []}  # m/s^2, of slip accelerations that are some 10 without these forces
    for now in states(machine, 7, FEW):
        hold(engine, now)
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
