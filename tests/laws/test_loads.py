"""Loads of the wheels against statics and levers: standing, pushed, braking, lifting a wheel, tipping, jammed."""

import numpy as np
import pytest
from machines import BOX, CHASSIS, axle_inertia, diameter_inertia, machine, run, scene, wheel_mass
from scenes import of_wheels

import omnisim

TRIANGLE = ((0.2, 0.02), (-0.1, 0.16), (-0.12, -0.15))
OFF_CENTRE = CHASSIS | {"center_of_mass": [0.03, -0.02, 0.12]}
G = 9.81
LEFT, FRONT = np.array(BOX)[:, 1], np.array(BOX)[:, 0]


def pushed(*force):
    return {"times": [0.0], "force": [list(force)]}


class Bodies:
    """Mass, common centre of mass, yaw inertia and sum of m z e of a machine on wheels of one kind."""

    def __init__(self, data, kind):
        wheel, places = data["wheel_types"][kind], [wheel["position"] for wheel in data["wheels"]]
        points = np.array([data["chassis"]["center_of_mass"], *[[*place, wheel["radius"]] for place in places]])
        masses = np.array([data["chassis"]["mass"], *[wheel_mass(kind)] * len(places)])
        self.mass, self.centre = masses.sum(), masses @ points / masses.sum()
        planar = points[:, :2] - self.centre[:2]
        own = data["chassis"]["inertia"][2] + len(places) * diameter_inertia(kind)
        self.yaw_inertia = own + masses @ np.sum(planar**2, axis=1)
        self.moment = masses * points[:, 2] @ planar


def lever_rule(data, kind, force):
    """Sum of the loads and of their products with x and y, of a machine at rest without friction: moments vanish.

    A force at the centre of mass of the chassis accelerates and turns the machine: each body's inertia acts at its own
    height.
    """
    whole, at = Bodies(data, kind), np.array(data["chassis"]["center_of_mass"])
    arm = at - whole.centre
    turning = (arm[0] * force[1] - arm[1] * force[0]) / whole.yaw_inertia
    tilting = arm[2] * np.array(force[:2]) + turning * np.array([whole.moment[1], -whole.moment[0]])
    planar = whole.mass * G * whole.centre[:2] - force[2] * at[:2] + tilting
    return np.array([whole.mass * G - force[2], *planar])


@pytest.mark.parametrize("force", [(0.0, 0.0, 0.0), (0.0, 0.0, 20.0), (30.0, -20.0, 0.0), (-25.0, 40.0, -50.0)])
def test_three_wheels_carry_what_the_lever_rule_says(force):
    data = machine("omni", TRIANGLE, [10.0, 130.0, 250.0], chassis=OFF_CENTRE, wrench=pushed(*force))
    loads = of_wheels(run(data, "time.end=0.01"), "normal_force")[0]
    x, y = np.transpose(TRIANGLE)
    expected = np.linalg.solve([np.ones(3), x, y], lever_rule(data, "omni", force))
    assert np.abs(loads - expected).max() < 1e-12  # N, of 10 to 50; measured 1.4e-14


@pytest.mark.parametrize("force", [(0.0, 0.0, 0.0), (0.0, 0.0, 20.0), (30.0, -20.0, 0.0), (-25.0, 40.0, -50.0)])
def test_four_wheels_carry_as_a_rigid_chassis_on_equal_springs(force):
    """Of all loads that the lever rule allows the one of least squares: a plane over the chassis."""
    data = machine("mecanum", chassis=OFF_CENTRE, wrench=pushed(*force))
    loads = of_wheels(run(data, "time.end=0.01"), "normal_force")[0]
    expected = np.linalg.pinv([np.ones(4), FRONT, LEFT]) @ lever_rule(data, "mecanum", force)
    assert np.abs(loads - expected).max() < 1e-12  # N; measured 2.1e-14


def test_a_machine_without_friction_keeps_its_motion():
    initial = {"velocity": [0.5, -0.3], "yaw_rate": 1.2}
    moved = run(machine("mecanum", chassis=OFF_CENTRE, initial=initial))
    centre = Bodies(machine("mecanum", chassis=OFF_CENTRE), "mecanum").centre
    yaw = 1.2 * moved.time
    arm = np.stack(
        [centre[0] * np.cos(yaw) - centre[1] * np.sin(yaw), centre[0] * np.sin(yaw) + centre[1] * np.cos(yaw)], 1
    )
    start = np.array([0.5, -0.3]) + 1.2 * np.array([-centre[1], centre[0]])  # of the common centre of mass
    expected = centre[:2] + np.outer(moved.time, start) - arm
    assert np.abs(moved["body/position"][:, :2] - expected).max() < 1e-14  # m; measured 1.1e-16
    assert np.abs(moved["body/yaw"] - yaw).max() < 1e-14


def test_the_servo_gives_every_wheel_the_same_load_and_takes_the_moment_itself():
    force = (30.0, -20.0, 12.0)
    data = machine(
        "omni", TRIANGLE, [10.0, 130.0, 250.0], chassis=OFF_CENTRE, wrench=pushed(*force), scene={"upright": "servo"}
    )
    still = run(data, "time.end=0.01")
    total, about_y, about_x = lever_rule(data, "omni", force)  # moments that the loads should have
    loads, (x, y) = of_wheels(still, "normal_force")[0], np.transpose(TRIANGLE)
    assert np.abs(loads - total / 3).max() < 1e-14 * total
    expected = [about_x - loads @ y, loads @ x - about_y]
    assert still["body/servo_torque"][0] == pytest.approx(expected, abs=1e-12)


def test_braking_shifts_load_to_the_front_by_the_height_of_the_centre_of_mass():
    """Wheels that roll and are braked: Delta N of an axle = -(M z_C + sum J_k / R) a / wheelbase."""
    torque, radius = -0.15, 0.0625
    data = machine("omni", drives=[{"kind": "torque", "torque": torque}] * 4, initial={"velocity": [1.0, 0.0]},
                   friction={"law": "coulomb", "coefficient": 0.8})  # fmt: skip
    for wheel in data["wheels"]:
        wheel["spin_rate"] = 1.0 / radius
    braking = run(data, "time.end=0.3")
    whole = Bodies(data, "omni")
    spin = 4 * axle_inertia("omni") / radius
    acceleration = 4 * torque / radius / (whole.mass + spin / radius)
    assert np.abs(braking["body/acceleration"][:, 0] - acceleration).max() < 1e-13  # m/s^2; measured 7e-16
    assert np.abs(braking["body/velocity"][:, 0] - 1.0 - acceleration * braking.time).max() < 1e-13
    loads = of_wheels(braking, "normal_force")
    shift = -(whole.mass * whole.centre[2] + spin) * acceleration / 0.4
    front, rear = loads[:, :2].sum(axis=1), loads[:, 2:].sum(axis=1)
    assert np.abs((front - rear) / 2 - shift).max() < 1e-12  # N; measured 1.8e-15
    assert "slip" not in braking["events/kind"] and "exchange" in braking["events/kind"]


HEAVY_BEHIND = [-0.14, -0.1, 0.1]
PRESSED = {"times": [0.0, 1.0, 2.0], "force": [[0.0, 0.0, 0.0], [0.0, 0.0, -80.0], [0.0, 0.0, 0.0]]}


def pressed(kind, law, places=BOX, centre=HEAVY_BEHIND):
    """A machine that is pressed down behind, then released, and the share of that at which w0 has no load."""
    data = machine(
        kind,
        places,
        chassis=CHASSIS | {"center_of_mass": centre},
        friction={"law": law, "coefficient": 0.5},
        wrench=PRESSED,
    )
    plane = np.linalg.pinv([np.ones(len(places)), *np.transpose(places)])
    none, all_ = ((plane @ lever_rule(data, kind, (0.0, 0.0, force)))[0] for force in (0.0, -80.0))
    return data, none / (none - all_)


@pytest.mark.parametrize("law", ["none", "coulomb"])
def test_a_wheel_leaves_the_floor_when_its_load_vanishes_and_comes_back_with_it(law):
    data, share = pressed("mecanum", law)
    lifted = run(data, "time.end=2.0")
    assert 0.1 < share < 0.9
    kinds = ["lift_off", "touch_down"] + ["stick"] * (law == "coulomb")
    assert list(lifted["events/kind"]) == kinds and set(lifted["events/wheel"]) == {"w0"}
    assert np.abs(lifted["events/time"][:2] - [share, 2.0 - share]).max() < 1e-11  # s; measured 3e-12
    loads, air = of_wheels(lifted, "normal_force"), np.abs(lifted.time - 1.0) < 1.0 - share
    assert np.all(loads[air, 0] == 0.0) and np.all(loads[~air, 0] > 0.0) and loads[:, 1:].min() > 1.0
    for row in np.flatnonzero(air):
        vertical = -80.0 * (1.0 - abs(lifted.time[row] - 1.0))
        expected = np.linalg.solve([np.ones(3), FRONT[1:], LEFT[1:]], lever_rule(data, "mecanum", (0.0, 0.0, vertical)))
        assert np.abs(loads[row, 1:] - expected).max() < 1e-12  # N; measured 6e-14
    assert np.abs(lifted["body/velocity"]).max() < 1e-14, "it stands"


def test_the_energy_is_balanced_while_a_wheel_is_in_the_air():
    """Sliding, turning and lifting w0 for a while: what spins in the air loses nothing."""
    data, _ = pressed("omni", "regularized")
    data["friction"]["slip_speed"] = 0.3
    data["initial"] = {"velocity": [0.6, 0.3], "yaw_rate": 2.0}
    runs = [run(data, "time.end=2.0", f"time.step={step}") for step in ("2e-5", "1e-5", "5e-6")]
    errors, slid = [np.abs(slid["energy/balance"]).max() for slid in runs], runs[-1]
    assert errors[-1] < 1e-9  # J, of 3; measured 9e-11
    assert np.log2(errors[0] / errors[-1]) / 2 >= 3.8, errors  # 4.02, through 11 times in the air
    kinds, times = slid["events/kind"], slid["events/time"]
    lifts, landings = times[kinds == "lift_off"], np.append(times[kinds == "touch_down"], 2.0)  # it ends in the air
    assert len(lifts) == len(landings) > 10 and np.all(lifts < landings)
    for lift, landing in zip(lifts, landings, strict=True):
        air = (slid.time > lift) & (slid.time < landing)
        rates = slid["wheels/w0/rollers/axial_rate"][air]
        assert np.all(rates == rates[:1]), "rollers in the air keep their rates"
        assert not slid["wheels/w0/friction_force"][air].any()
    assert np.sum(landings - lifts) > 0.5


@pytest.mark.parametrize("seed", [1, 4, 7, 8, 30, 47])
def test_a_wheel_that_rattles_on_the_floor_neither_jams_the_machine_nor_stops_its_time(seed):
    """Loads that jump and rattle, with four wheels that spin and a corner that is nearly without load."""
    rng = np.random.default_rng(seed)
    data, _ = pressed("mecanum", "coulomb")
    data["wrench"] = {"times": [0.0], "force": [[0.0, 0.0, -60.0]]}
    data["initial"] = {"velocity": rng.normal(size=2).round(1).tolist(), "yaw_rate": float(rng.normal(scale=4.0))}
    for wheel in data["wheels"]:
        wheel["spin_rate"] = float(rng.normal(scale=60.0))
    rattling = run(data, "solver.method=auto")
    kinds, times, wheels = (rattling[f"events/{name}"] for name in ("kind", "time", "wheel"))
    for name in rattling.wheels:
        own = np.isin(kinds, ["lift_off", "touch_down"]) & (wheels == name)
        assert np.all(times[own][2:] > times[own][:-2]), "two changes of a wheel at one instant, and no more"
    assert np.count_nonzero(kinds == "lift_off") >= 5


def test_a_machine_on_three_wheels_tips_when_one_of_them_leaves_the_floor():
    data, share = pressed("omni", "none", BOX[:1] + BOX[2:], [-0.22, 0.0, 0.1])
    tipped = omnisim.simulate(scene(data, "time.end=2.0"))
    assert tipped.attributes["status"].startswith(f"the machine tips at t = {share:.9g} s: wheel 'w0' leaves the floor")
    assert tipped.attributes["stop_wheel"] == "w0" and abs(tipped.attributes["stop_time"] - share) < 1e-12
    assert list(tipped["events/kind"]) == ["lift_off", "stop"]
    assert len(tipped.time) == int(share / 0.01) + 1 and of_wheels(tipped, "normal_force").min() > 0.0


def test_a_machine_held_by_a_servo_takes_off_when_the_force_lifts_its_weight():
    rising = {"times": [0.0, 1.0], "force": [[0.0, 0.0, 0.0], [0.0, 0.0, 200.0]]}
    data = machine("omni", BOX[:2], wrench=rising, scene={"upright": "servo"})
    lifted = omnisim.simulate(scene(data))
    assert (
        "leaves the floor" in lifted.attributes["status"]
        and "lifts more than the weight" in lifted.attributes["status"]
    )
    assert abs(lifted.attributes["stop_time"] - Bodies(data, "omni").mass * G / 200.0) < 1e-12


@pytest.mark.parametrize(("height", "jams"), [(0.2, False), (0.23, True)])
def test_wheels_that_skid_towards_one_another_jam_a_tall_machine(height, jams):
    """More load on one of two wheels, F = mu N towards the other, tilts the machine so as to load it still more.

    Where mu (z_C - R) reaches half their distance nothing balances it: a Painleve state (R F spins the wheel down). At
    the start their rollers skid sideways too; they spin up, and the forces turn towards one another.
    """
    half, mu = 0.11, 0.9
    data = machine("omni", ((-0.06, half), (-0.06, -half), (0.15, 0.0)), [-90.0, 90.0, 0.0],
                   chassis=CHASSIS | {"center_of_mass": [0.0, 0.0, height]},
                   friction={"law": "coulomb", "coefficient": mu})  # fmt: skip
    for wheel, sense in zip(data["wheels"][:2], (1, -1), strict=True):
        wheel |= {"spin_rate": 50.0, "roller_rates": -300.0 * sense}
    skidding = omnisim.simulate(scene(data, "time.end=0.02", "time.step=1e-4", "time.output_interval=1e-4"))
    critical = mu * (Bodies(data, "omni").centre[2] - 0.0625) / half
    force = skidding["wheels/w0/friction_force"]
    inward = force[:, 0] / np.linalg.norm(force, axis=1)
    assert inward[0] * critical < 0.99 and (critical > 1.0) == jams
    if jams:
        assert skidding.attributes["status"].startswith("friction jams at t =")
        assert 1e-4 < skidding.attributes["stop_time"] < 5e-3 and len(skidding.time) > 1
        assert inward[-1] * critical < 0.99 < inward[-1] * critical + 2 * np.diff(inward)[-1] * critical
    else:
        assert skidding.complete and inward.max() > 0.99
