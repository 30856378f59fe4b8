"""Loads of the wheels at standstill."""

import numpy as np
import pytest

import omnisim
from omnisim.dynamics.packing import bodies, pack
from omnisim.dynamics.static_loads import static_loads
from omnisim.scene.scene import load

pytestmark = pytest.mark.short

VEHICLES = ("authors_vehicle", "kiwi", "mixed", "soccer_kit", "soccer_robot", "youbot")
CORNER = "chassis.center_of_mass=[0.05, 0.05, 0.06]"  # of soccer_robot: beyond what four equal springs carry


def loads_of(name, *overrides):
    config = load(name, overrides).config
    return config, static_loads(pack(config))


@pytest.mark.parametrize("name", VEHICLES)
@pytest.mark.parametrize("upright", ["contacts", "servo"])
def test_loads_carry_the_weight(name, upright):
    config, loads = loads_of(name, f"scene.upright={upright}")
    assert loads.sum() == pytest.approx(bodies(config).mass * config.world.gravity, rel=1e-14)
    assert (loads > 0.0).all()
    assert upright == "contacts" or np.ptp(loads) == 0.0


@pytest.mark.parametrize("name", [*VEHICLES, "corner"])
def test_contacts_balance_about_the_common_centre_of_mass(name):
    config, loads = loads_of("soccer_robot", CORNER) if name == "corner" else loads_of(name)
    arms = np.array([wheel.position for wheel in config.wheels]) - bodies(config).centre[:2]
    assert np.abs(loads @ arms).max() < 1e-14 * loads.sum()  # 7e-17


def test_a_wheel_that_springs_would_pull_down_carries_nothing():
    _, loads = loads_of("soccer_robot", CORNER)
    assert (loads == 0.0).tolist() == [False, False, True, False]  # rear_right, opposite of the corner


def test_a_lift_takes_off_load_until_there_is_none():
    parameters = pack(load("youbot").config)
    weight = parameters.machine.mass * parameters.machine.gravity
    assert static_loads(parameters, 0.25 * weight) == pytest.approx(0.75 * static_loads(parameters))
    assert static_loads(parameters, 2.0 * weight).tolist() == [0.0] * 4


def test_a_machine_that_stands_still_has_these_loads():
    # Omni wheels, psi = 0: rollers touch exactly below the wheel centres
    scene = load("soccer_kit", ["time.end=0.01"])
    run = omnisim.simulate(scene)
    start = [run[f"wheels/{wheel}/normal_force"][0] for wheel in run.wheels]
    assert static_loads(pack(scene.config)) == pytest.approx(start, rel=1e-13)
