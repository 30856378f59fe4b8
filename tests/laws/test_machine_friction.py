"""Coulomb friction at several wheels at once: the law at every row, rolling in closed form, rest, order, odometry."""

import numpy as np
import pytest
from machines import axle_inertia, machine, run, scene, tables, wheel_mass
from scenes import final_state, of_wheels, reference_scene

import omnisim
from omnisim.contact.set_valued import CREEP, SLIP, STICK
from omnisim.dynamics.impulses import align_slip
from omnisim.dynamics.state import Stage, places_in
from omnisim.dynamics.twist import body_motion
from omnisim.dynamics.wheel import contact_state
from omnisim.march.runge_kutta import evaluate
from omnisim.scene.ideal_kinematics import wheel_rows

COULOMB = {"law": "coulomb", "coefficient": 0.5}
MASS = 6.0 + 4 * wheel_mass("mecanum")
RADIUS, AXIAL, J = 0.0475, 3.1e-6, axle_inertia("mecanum")

# A youbot whose torques make all wheels slip now and then, each at a time of its own.
SPINNING = [{"kind": "torque", "times": [0.0, 0.3, 0.6, 1.0], "torque": torque} for torque in
            ([0.0, 2.2, -1.0, 0.5], [0.0, 1.2, 2.0, -1.0], [0.0, -0.5, 2.1, 0.0], [0.0, 1.0, -1.9, 1.0])]  # fmt: skip


def driven():
    data = tables("youbot")
    del data["command"]
    for wheel, drive in zip(data["wheels"], SPINNING, strict=True):
        wheel["drive"] = drive
    data["time"] = {"end": 1.0, "step": 1e-3, "output_interval": 0.005}
    data["solver"] = {"method": "auto"}
    return data


@pytest.mark.parametrize(("method", "lost"), [("rk4", 5e-6), ("auto", 5e-7), ("radau5", 1e-8)])
def test_every_contact_obeys_the_law_at_every_row_while_others_stick_and_slip(method, lost):
    spinning = run(driven(), f"solver.method={method}")
    slip, force = of_wheels(spinning, "slip_velocity"), of_wheels(spinning, "friction_force")
    limit, speed, size = 0.6 * of_wheels(spinning, "normal_force"), np.hypot(*slip.T).T, np.hypot(*force.T).T
    sticks = speed < 1e-9
    some = sticks.any(axis=1) & ~sticks.all(axis=1)
    assert some.sum() > 50, "rows where some wheels stick and others slip"
    assert np.all(size <= limit + 1e-12 * limit.max())
    assert np.abs(size - limit)[~sticks].max() < 1e-12 * limit.max()
    along = np.sum(force * slip, axis=2)[~sticks] / (speed * size)[~sticks]
    assert np.abs(along + 1.0).max() < 1e-12, "friction opposes the slip"
    assert speed[sticks].max() < 1e-11  # m/s; measured 6.7e-12
    work = spinning["energy/drive_work"].max()
    assert np.abs(spinning["energy/balance"]).max() < lost * work  # measured 1.7e-6, 1.1e-7, 3.5e-9 of it


# Explicit steps follow slow slip in the direction of the contact equation; "auto" makes its sub-steps implicit.
LADDERS = {
    "rk4": ((1e-3, 2.5e-4), 3.7),
    "dopri5": ((1e-3, 2.5e-4), 4.0),
    "auto": ((1e-3, 1.25e-4), 2.5),
    "radau5": ((1e-3, 1.25e-4), 2.9),
}


@pytest.mark.long
def test_methods_converge_on_one_motion_of_a_machine_that_sticks_and_slips():
    """231 exchanges, 34 times a wheel lets go and 32 times it stops: the same in each of the runs."""
    fine = run(driven(), "solver.method=radau5", "time.step=5e-5")
    for method, (steps, order) in LADDERS.items():
        runs = [run(driven(), f"solver.method={method}", f"time.step={step}") for step in steps]
        assert all(sorted(other["events/kind"]) == sorted(fine["events/kind"]) for other in runs)
        first, last = (np.abs(final_state(other) - final_state(fine)).max() for other in runs)
        # measured 7.0e-5, 2.8e-7; 5.3e-7, 1.4e-9; 7.3e-6, 3.3e-8; 1.2e-7, 2.9e-10
        assert first < 1e-4 and last < 5e-7, method
        assert np.log(first / last) / np.log(steps[0] / steps[1]) >= order, method  # 4.0, 4.3, 2.6, 2.9


def test_wheels_that_slip_slowly_together_cost_few_sub_steps():
    """Each exchange jolts the slips of all other wheels: sub-steps follow what that leaves until it has died away."""
    coarse, fine = (run(driven(), "solver.method=dopri5", f"time.step={step}") for step in (5e-4, 2.5e-4))
    assert coarse.attributes["rhs_evaluations"] < 140_000  # 128,923; following all turning by sub-steps took 462,548
    assert np.abs(final_state(coarse) - final_state(fine)).max() < 1e-8  # measured 4.5e-9; by 81,129 of them 5.7e-8


@pytest.mark.parametrize("name", ["kiwi", "youbot", "mixed"])
def test_both_trackings_move_a_machine_alike(name):
    runs = [run(tables(name), f"solver.tracking={tracking}") for tracking in ("explicit", "implicit")]
    assert list(runs[0]["events/kind"]) == list(runs[1]["events/kind"])
    assert np.abs(final_state(runs[0]) - final_state(runs[1])).max() < 1e-9  # measured 1e-13, 2e-16, 6e-11


def test_a_machine_rolls_off_with_the_inertia_of_what_turns():
    """Four equal torques: a = sum tau / R / (M + sum (J_k + Ia sin(psi)^2) / R^2) on the first rollers."""
    torque = 0.05
    rolling = run(machine("mecanum", drives=[{"kind": "torque", "torque": torque}] * 4, friction=COULOMB))
    acceleration = 4 * torque / RADIUS / (MASS + 4 * (J + AXIAL / 2) / RADIUS**2)
    first = rolling["events/time"][0]
    assert abs(first - np.sqrt(2 * RADIUS * np.pi / 6 / acceleration)) < 1e-13  # s; measured 1.7e-16
    assert np.ptp(rolling["events/time"][rolling["events/kind"] == "exchange"][:4]) < 1e-15
    before = rolling.time < first
    expected = acceleration * rolling.time[before]
    assert np.abs(rolling["body/velocity"][before, 0] - expected).max() < 1e-14  # m/s; measured 7e-17
    assert np.abs(rolling["body/position"][before, 0] - expected * rolling.time[before] / 2).max() < 1e-15


def test_the_gear_of_a_rolling_mecanum_wheel_to_the_side_ripples():
    """Without slip V_y = -+ phi' R cos(q) / tan(psi): an ideal wheel has cos(q) = 1."""
    strafing = [{"kind": "torque", "torque": sense * 0.02} for sense in (-1, 1, 1, -1)]
    rolling = run(machine("mecanum", drives=strafing, friction=COULOMB), "time.end=2.0")
    sticks = np.hypot(*of_wheels(rolling, "slip_velocity").T).T < 1e-10
    for w, sense in enumerate((-1, 1, 1, -1)):
        q, rate = rolling[f"wheels/w{w}/contact_angle"], rolling[f"wheels/w{w}/spin_rate"]
        rolls = sticks[:, w]
        assert rolls.sum() > 100 and np.ptp(np.cos(q[rolls])) > 0.1
        expected = sense * rate * RADIUS * np.cos(q)
        assert np.abs(rolling["body/velocity"][rolls, 1] - expected[rolls]).max() < 1e-10  # m/s; measured 1.3e-12


@pytest.mark.parametrize("push", [(8.0, 0.0, 0.0), (0.0, -6.0, 0.0), (5.0, 3.0, 0.4)])
def test_drives_hold_a_machine_still_against_a_push(push):
    """On the middle of its rollers it is an ideal machine: tau = -pinv(rows)^T f does no work with f in any motion."""
    data = machine("mecanum", friction=COULOMB)
    data["wrench"] = {"times": [0.0], "force": [[push[0], push[1], 0.0]], "yaw_torque": [push[2]]}
    torques = -np.linalg.pinv(wheel_rows(scene(data).config)).T @ push
    for wheel, torque in zip(data["wheels"], torques, strict=True):
        wheel["drive"] = {"kind": "torque", "torque": float(torque)}
    still = run(data)
    assert np.abs(still["body/velocity"]).max() < 1e-13 and np.abs(of_wheels(still, "spin_rate")).max() < 1e-11
    forces = of_wheels(still, "friction_force").sum(axis=1)
    assert np.abs(forces + push[:2]).max() < 1e-12  # N; measured 3e-15
    assert not len(still["events/time"])


@pytest.mark.parametrize("name", ["youbot", "mixed", "kiwi", "soccer_robot"])
def test_a_braked_machine_comes_to_rest_from_any_motion(name):
    """Wheels told not to turn; it may come to rest on two rollers."""
    for seed in range(8):
        rng = np.random.default_rng(seed)
        data = tables(name)
        data.pop("command", None)
        data["friction"], data["solver"] = {"law": "coulomb", "coefficient": 0.4}, {"method": "auto"}
        data["initial"] = {"velocity": rng.normal(scale=0.3, size=2).tolist(), "yaw_rate": float(rng.normal(scale=2.0))}
        for wheel in data["wheels"]:
            wheel["drive"] = {"kind": "rate", "rate": 0.0, "proportional": 0.5, "torque_limit": 0.3}
            wheel["spin_rate"], wheel["spin_angle_deg"] = (
                float(rng.normal(scale=10.0)),
                float(rng.uniform(-180.0, 180.0)),
            )
        data["time"] = {"end": 6.0, "step": 1e-3, "output_interval": 0.1}
        braked = run(data)
        rates = [*braked["body/velocity"][-1], braked["body/yaw_rate"][-1], *of_wheels(braked, "spin_rate")[-1]]
        assert np.abs(rates).max() < 1e-9, seed  # measured up to 1.3e-10
        assert np.abs(of_wheels(braked, "slip_velocity")[-1]).max() < 1e-9
        lost = braked["energy/friction_loss"] - braked["energy/drive_work"]
        assert np.abs(braked["energy/balance"]).max() < 1e-4 * lost[-1]


def test_odometry_of_omni_wheels_that_roll_tells_the_true_pose():
    """psi = 0 and no slip: phi' R = V_h whatever the roller, so the ideal wheel is exact up to skids at exchanges."""
    slow = tables("kiwi") | {"command": {"times": [0.0, 2.0], "twist": [[0, 0, 0], [0.02, 0.01, 0.05]]}}
    slow["initial"] = {"position": [1.0, -2.0], "yaw_deg": 30.0}
    slow["wheels"][0]["spin_angle_deg"] = 100.0
    rolled = run(slow)
    assert np.array_equal(rolled["odometry/position"][0], rolled["body/position"][0, :2])
    assert abs(rolled["odometry/yaw"][0] - rolled["body/yaw"][0]) < 1e-15
    moved = np.abs(rolled["body/position"][-1, :2] - [1.0, -2.0]).max()
    first = rolled.time < rolled["events/time"][0]
    assert first.sum() > 10 and np.abs(rolled["odometry/position_error"][first]).max() < 1e-12  # m; measured
    assert np.abs(rolled["odometry/yaw_error"][first]).max() < 1e-12
    assert moved > 0.03 and np.abs(rolled["odometry/position_error"]).max() < 1e-2 * moved


def test_odometry_is_the_integral_of_what_ideal_wheels_would_do():
    """Whatever the slip: the yaw from the spin angles, the position by turning and adding up their velocity."""
    spinning = run(driven(), "time.output_interval=0.001")
    rows = np.linalg.pinv(wheel_rows(scene(driven()).config))
    twists = of_wheels(spinning, "spin_rate") @ rows.T
    yaw = of_wheels(spinning, "spin_angle") @ rows[2]
    assert np.abs(spinning["odometry/yaw"] - yaw).max() < 1e-12
    turned = (twists[:, 0] + 1j * twists[:, 1]) * np.exp(1j * yaw)
    travelled = np.concatenate([[0.0], np.cumsum((turned[1:] + turned[:-1]) / 2 * 0.001)])
    reported = spinning["odometry/position"] @ [1.0, 1j]
    assert np.abs(reported - travelled).max() < 1e-4  # m, of 1: trapezia; measured 3e-5


def bare_and_carried(law, psi):
    """The reference wheel with a heavier disk, and the same wheel under a chassis of the difference."""
    bare = tables(reference_scene("testbench_psi30", f"friction.law={law}", f"wheel_types.omni.roller_angle_deg={psi}",
                                  "time.end=2.0", "time.step=2e-4", "time.output_interval=0.02"))  # fmt: skip
    carried = {**bare, "wheel_types": {"omni": dict(bare["wheel_types"]["omni"])}, "wheels": [dict(bare["wheels"][0])]}
    kind = bare["wheel_types"]["omni"]
    carried["chassis"] = {"mass": 0.8, "center_of_mass": [0.0, 0.0, kind["radius"]], "inertia": [0.01, 0.01, 0.004]}
    carried["wheels"][0]["position"] = [0.0, 0.0]
    carried["scene"] = bare.get("scene", {}) | {"upright": "servo"}
    disk = dict(kind["disk"])
    disk["mass"] += 0.8
    disk["inertia_diameter"] += 0.004
    bare["wheel_types"] = {"omni": kind | {"disk": disk}}
    return bare, carried


@pytest.mark.parametrize("psi", [0.0, 30.0])
@pytest.mark.parametrize("law", ["coulomb", "regularized", "none"])
def test_a_chassis_at_the_centre_of_its_only_wheel_is_part_of_that_wheel(law, psi):
    bare, carried = (run(data) for data in bare_and_carried(law, psi))
    assert np.abs(bare["body/position"][:, :2] - carried["body/position"][:, :2]).max() < 1e-12
    assert np.abs(bare["body/yaw"] - carried["body/yaw"]).max() < 1e-12
    for path in ("spin_angle", "normal_force", "contact_share"):
        np.testing.assert_allclose(of_wheels(carried, path), of_wheels(bare, path), rtol=0, atol=1e-9)
    force, speed = of_wheels(bare, "friction_force"), np.linalg.norm(of_wheels(bare, "slip_velocity"), axis=-1)
    error = np.linalg.norm(of_wheels(carried, "friction_force") - force, axis=-1)  # N
    slow = (speed > 1e-9) & (speed < 1e-3)  # m/s: of slip so slow the direction is as uncertain as its rounding
    assert error[~slow].max() < 1e-9  # measured 2.3e-12
    assert np.all(error[slow] * speed[slow] < 1e-14 * np.linalg.norm(force, axis=-1)[slow])  # m/s; measured 1.2e-15
    heading = carried["body/servo_torque"][:, 0]
    np.testing.assert_allclose(heading, bare["wheels/wheel/servo_torque"], rtol=0, atol=1e-9)


def test_two_wheels_side_by_side_under_a_servo_roll_straight():
    torque, places = 0.03, ((0.0, 0.15), (0.0, -0.15))
    data = machine(
        "omni", places, drives=[{"kind": "torque", "torque": torque}] * 2, friction=COULOMB, scene={"upright": "servo"}
    )
    rolling, radius = run(data), 0.0625
    mass = 6.0 + 2 * wheel_mass("omni")
    acceleration = 2 * torque / radius / (mass + 2 * axle_inertia("omni") / radius**2)
    assert np.abs(rolling["body/velocity"][:, 0] - acceleration * rolling.time).max() < 1e-13
    assert np.abs(of_wheels(rolling, "normal_force") - mass * 9.81 / 2).max() < 1e-12
    centre = (6.0 * 0.1 + 2 * wheel_mass("omni") * radius) / mass
    pitch = mass * acceleration * centre + 2 * axle_inertia("omni") * acceleration / radius
    assert np.abs(rolling["body/servo_torque"][:, 1] - pitch).max() < 1e-12  # N m
    assert np.abs(rolling["body/servo_torque"][:, 0]).max() < 1e-12


def kinetic(parameters, run):
    """Kinetic energy, J, but of the rollers in the air."""
    machine, at, y = parameters.machine, places_in(parameters), run.y
    doubled = machine.mass * (y[at.velocity] ** 2 + y[at.velocity + 1] ** 2) + machine.yaw_inertia * y[at.yaw_rate] ** 2
    for w, wheel in enumerate(parameters.wheels):
        doubled += (wheel.axle_inertia + wheel.rotor_inertia) * y[at.spin_rate + w] ** 2
        doubled += wheel.axial_inertia * y[at.roller_rate + 2 * w] ** 2
    return 0.5 * doubled


@pytest.mark.parametrize("seed", range(5))
def test_impulses_that_take_slip_away_cost_what_friction_is_said_to_lose(seed):
    """Wheels 0 and 1 stick, 2 creeps along a direction of its own, 3 slips on; all speeds are disturbed."""
    loop = omnisim.Loop(scene(driven()))
    parameters, run, at, random = loop.parameters, loop.run, places_in(loop.parameters), np.random.default_rng(seed)
    run.y[at.velocity : at.integral] += random.normal(size=at.integral - at.velocity)
    run.mode.grip[:, 0], run.mode.creep[2, 0] = (STICK, STICK, CREEP, SLIP), (0.8, -0.6)
    before, lost = kinetic(parameters, run), run.y[at.friction_loss]
    align_slip(parameters, run, False)
    body = body_motion(parameters, run.y)
    slips = [contact_state(parameters, run.mode[w], w, 0, body, run.y).slip for w in range(3)]
    assert np.abs(slips[:2]).max() < 1e-12 and abs(slips[2].h * 0.6 + slips[2].k * 0.8) < 1e-12  # m/s
    loss = run.y[at.friction_loss] - lost
    assert loss > 1e-3 * before
    assert abs(before - kinetic(parameters, run) - loss) < 1e-12 * before


def test_a_wheel_that_slides_after_it_has_crept_seeks_no_force():
    """Wheel 3 has crept, and slides beside one that creeps: the forces are those of a machine that never crept there,
    to the last bit, and without a search for its own."""
    found = []
    for before in (CREEP, SLIP):
        loop = omnisim.Loop(scene(driven() | {"solver": {"method": "rk4"}}))
        parameters, run, at = loop.parameters, loop.run, places_in(loop.parameters)
        loop.march(0)
        run.y[at.velocity : at.integral] += 1e-3 * np.random.default_rng(0).normal(size=at.integral - at.velocity)
        run.mode.creep[2:, 0] = 0.8, -0.6
        for last in (before, SLIP):
            run.mode.grip[:, 0] = STICK, STICK, CREEP, last
            parameters.workspace.contacts["creep"] = 0.0  # a search begins with the direction of the mode
            evaluate(parameters, Stage(run.mode, 0, 0.0, run.y, run.slopes[0], run.monitors, True))
        found.append(run.slopes[0].tobytes())
        assert parameters.workspace.parts["sought"].tolist() == [0, 0, 1, 0]
    assert found[0] == found[1]
