"""Machines free in space at rest and near it, against closed forms: sag, loads, small oscillations, landing.

M: mass, k: stiffness of the rubber, z_C: height of the centre of mass. Measured values stand beside the bounds.
"""

import copy

import numpy as np
import pytest
from free_machines import STIFFNESS, free, whole_mass
from machines import BOX, CHASSIS, TYPES, diameter_inertia, machine, run, scene, wheel_mass
from scenes import of_wheels

from omnisim.dynamics.packing import bodies, pack
from omnisim.march.spatial_start import standing_pose
from omnisim.scene.problems import ConfigError

G = 9.81
OMNI = TYPES["omni"]
TRIANGLE = tuple((0.2 * np.cos(angle), 0.2 * np.sin(angle)) for angle in np.radians([60.0, 180.0, 300.0]))
SMALL = 1e-6  # rad, of oscillations


def rest(data: dict):
    """Pose in static equilibrium and loads of the wheels (W,), N."""
    config = scene(data).config
    return standing_pose(config, pack(config))


def kiwi(**changed) -> dict:
    """Three wheels on a triangle, the centre of mass in its middle."""
    return free(machine("omni", TRIANGLE, (150.0, 270.0, 30.0), **changed))


def turned_wheels(data: dict, spin_angle_deg: float) -> dict:
    data = copy.deepcopy(data)
    for wheel in data["wheels"]:
        wheel["spin_angle_deg"] = spin_angle_deg
    return data


def roll_and_pitch(motion):
    """Of the chassis in every row, rad."""
    w, x, y, z = motion["body/orientation"].T
    return np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), np.arcsin(2 * (w * y - z * x))


def test_rubber_sags_by_its_share_of_the_weight():
    """M g / (3 k), and each wheel carries M g / 3."""
    data = kiwi()
    pose, loads = rest(data)
    weight = whole_mass(data) * G
    assert abs(-pose.height * 3.0 * STIFFNESS / weight - 1.0) < 1e-11  # measured 5e-14
    assert np.abs(3.0 * loads / weight - 1.0).max() < 1e-11  # 1e-13
    assert max(abs(pose.roll), abs(pose.pitch)) < 1e-14


def test_where_two_rollers_meet_they_share_the_rubber_and_the_hub_rises_by_half_the_sag():
    """At the common edge of an exact wheel, pi / 10 from the middle of a roller."""
    data = kiwi()
    sag, edge = -rest(data)[0].height, -rest(turned_wheels(data, 18.0))[0].height
    assert abs(edge / sag - 0.5) < 1e-11  # measured 9e-14


@pytest.mark.parametrize("spin_angle_deg", [0.0, 5.0, 12.0, 16.0])
def test_barrels_roll_at_the_height_of_their_arc_then_of_their_rim(spin_angle_deg):
    """Below R by (R - rho) (1 - cos alpha) while rho sin alpha <= half_length, else by
    R - ((R1 + r_end) cos alpha + half_length sin alpha), and by the sag."""
    distance, radius, rho, half = 0.053, 0.0095, 0.045, 0.01
    data = turned_wheels(kiwi(), spin_angle_deg)
    data["wheel_types"]["omni"] = OMNI | {
        "contact": {"stiffness": 1e6},
        "profile": {"kind": "arc", "radius": radius, "curvature_radius": rho, "half_length": half},
    }
    alpha, wheel = np.radians(spin_angle_deg), distance + radius
    end = radius - rho + np.sqrt(rho**2 - half**2)
    below = (wheel - rho) * (1.0 - np.cos(alpha))
    if rho * np.sin(alpha) > half:
        below = wheel - ((distance + end) * np.cos(alpha) + half * np.sin(alpha))
    expected = -below - whole_mass(data) * G / 3e6
    assert abs(rest(data)[0].height - expected) < 1e-15  # m; measured 6e-18


def test_the_wheels_uphill_lose_load_until_the_machine_tips():
    """N_up / N_0 = 1 - tan S / tan S_tip, tan S_tip = b / z_C, but for its tilt, which falls with the stiffness."""
    data = free(machine("omni"), 1e8)
    steepest = BOX[0][0] / bodies(scene(data).config).centre[2]
    for part in (0.2, 0.7, 0.9, 0.99):
        slope = np.arctan(part * steepest)
        pose, loads = rest(data | {"floor": {"slope_deg": float(np.degrees(slope))}})
        level = whole_mass(data) * G * np.cos(slope) / 4.0
        ratios = [1.0 - part, 1.0 - part, 1.0 + part, 1.0 + part]
        assert np.abs(loads / level - ratios).max() < 2e-6, part  # measured 8e-7; ten times less with 1e9 N/m
        assert pose.pitch < 0.0  # its nose rises
    with pytest.raises(ConfigError, match="no pose at rest"):
        rest(data | {"floor": {"slope_deg": float(np.degrees(np.arctan(1.01 * steepest)))}})


def test_a_centre_of_mass_beside_the_middle_loads_the_wheels_as_levers_do():
    """On equal rubber loads are a plane over the chassis, N_i = M g (1 + x_i x_C / x^2 + y_i y_C / y^2) / 4."""
    data = free(machine("omni", chassis=CHASSIS | {"center_of_mass": [0.05, -0.04, 0.1]}), 1e8)
    x, y, _ = bodies(scene(data).config).centre
    places = np.array(BOX)
    expected = whole_mass(data) * G / 4.0 * (1.0 + places @ [x / 0.2**2, y / 0.15**2])
    assert np.abs(rest(data)[1] / expected - 1.0).max() < 1e-6  # measured 3e-7


def test_a_machine_heaves_at_the_frequency_of_its_rubber():
    """z = -sag + A cos(sqrt(3 k / M) t), exactly: rubber without damping is linear while it is pressed in."""
    data = kiwi(time={"end": 0.1, "step": 1e-5, "output_interval": 1e-3})
    mass = whole_mass(data)
    sag = mass * G / (3.0 * STIFFNESS)
    motion = run(data | {"initial": {"height": -1.5 * sag}})
    expected = -sag - 0.5 * sag * np.cos(np.sqrt(3.0 * STIFFNESS / mass) * motion.time)
    assert np.abs(motion["body/position"][:, 2] - expected).max() < 1e-10 * sag  # measured 7e-12
    loads = of_wheels(motion, "normal_force")
    assert np.abs(loads + STIFFNESS * expected[:, None]).max() < 1e-10 * mass * G  # 2e-12


def oscillation(data: dict, **initial):
    """A motion that begins at the height of equilibrium, turned or turning a little."""
    sag = whole_mass(data) * G / (4.0 * STIFFNESS)
    time = {"end": 0.2, "step": 2e-5, "output_interval": 1e-3}
    return run(data | {"initial": {"height": -sag} | initial, "time": time})


def moment(axis: int) -> float:
    """Inertia of a machine on four omni wheels about its centre of mass, without what turns on its own, kg m^2."""
    data = machine("omni")
    centre, mass = bodies(scene(data).config).centre, wheel_mass("omni")
    arms = [np.array([*place, OMNI["radius"]]) - centre for place in BOX]
    arm = np.array(CHASSIS["center_of_mass"]) - centre
    point = sum(mass * (r @ r - r[axis] ** 2) for r in arms) + CHASSIS["mass"] * (arm @ arm - arm[axis] ** 2)
    return CHASSIS["inertia"][axis] + point + (4.0 * diameter_inertia("omni") if axis == 0 else 0.0)


def test_a_machine_pitches_and_rolls_at_its_frequencies():
    """About C, which friction does not push: I w^2 = k sum x^2 - M g (z_C - R) in pitch, where wheels are round, and
    k sum y^2 - M g (z_C - (R - R1)) in roll, where the rollers below are. Without friction axles and rollers keep
    their rates, so J_k and Ia take no part."""
    data = free(machine("omni"))
    weight, height = whole_mass(data) * G, bodies(scene(data).config).centre[2]
    thickness = OMNI["radius"] - OMNI["roller_distance"]
    for axis, key, level, squares in ((1, "pitch_deg", OMNI["radius"], 0.16), (0, "roll_deg", thickness, 0.09)):
        motion = oscillation(data, **{key: float(np.degrees(SMALL))})
        rate = np.sqrt((STIFFNESS * squares - weight * (height - level)) / moment(axis))
        found = roll_and_pitch(motion)[axis]
        # measured 1.3e-9, its square by how far the rubber is pressed in
        assert np.abs(found - SMALL * np.cos(rate * motion.time)).max() < 1e-8 * SMALL, key


def test_springs_and_rubber_heave_as_two_masses_each_with_their_dampers():
    """M_c z'' = 4 f - M_c g, m_h h'' = -f - m_h g - k h - c h', f = preload + K (h - z) + C (h' - z'): linear."""
    spring = {"mass": 0.3, "inertia": 1e-4, "stiffness": 5e3, "damping": 60.0, "preload": 10.0}
    data = free(machine("omni", time={"end": 0.2, "step": 1e-5, "output_interval": 2e-3}), damping=50.0)
    for wheel in data["wheels"]:
        wheel["suspension"] = spring
    hub, body, height = wheel_mass("omni") + spring["mass"], CHASSIS["mass"] / 4.0, -1.2e-4
    motion = run(data | {"initial": {"height": height}})
    k, c, stiff, damp = STIFFNESS, 50.0, spring["stiffness"], spring["damping"]
    # heights of chassis and hub over the nominal ones, and their rates
    matrix = np.array([
        [0, 0, 1, 0], [0, 0, 0, 1], [-stiff / body, stiff / body, -damp / body, damp / body],
        [stiff / hub, -(stiff + k) / hub, damp / hub, -(damp + c) / hub],
    ])  # fmt: skip
    steady = np.array([0.0, 0.0, spring["preload"] / body - G, -spring["preload"] / hub - G])
    rest_at = -np.linalg.solve(matrix, steady)
    rates, ways = np.linalg.eig(matrix)
    parts = np.linalg.solve(ways, np.array([height, height, 0.0, 0.0]) - rest_at)
    expected = rest_at + np.real(np.exp(np.outer(motion.time, rates)) * parts @ ways.T)
    assert np.abs(motion["body/position"][:, 2] - expected[:, 0]).max() < 1e-15  # m, of 1e-3; measured 3e-17
    travel = of_wheels(motion, "suspension_travel") - (expected[:, 1] - expected[:, 0])[:, None]
    assert np.abs(travel).max() < 1e-14  # 4e-16
    assert np.abs(motion["energy/balance"]).max() < 1e-10 * motion["energy/damper_loss"][-1]  # 1e-12


def test_a_machine_lands_and_bounces_when_the_parabola_says():
    """Without damping: down for sqrt(2 h / g), on the ground for 2 (pi - atan(v w / g)) / w, w^2 = 4 k / M, and up."""
    data, height = free(machine("omni")), 2e-3
    motion = run(data | {"initial": {"height": height}, "time": {"end": 0.1, "step": 1e-5, "output_interval": 1e-3}})
    down, rate = np.sqrt(2.0 * height / G), np.sqrt(4.0 * STIFFNESS / whole_mass(data))
    speed = G * down
    pressed = 2.0 * (np.pi - np.arctan(speed * rate / G)) / rate
    landings, jumps = (motion["events/time"][motion["events/kind"] == kind] for kind in ("touch_down", "lift_off"))
    assert len(landings) == len(jumps) == 8  # four wheels, twice
    assert np.abs(landings[:4] - down).max() < 1e-13  # s; measured 0
    assert np.abs(jumps[:4] - down - pressed).max() < 1e-12  # measured 9e-15
    assert np.abs(landings[4:] - 3.0 * down - pressed).max() < 1e-12
    assert np.abs(motion["energy/balance"]).max() < 1e-12  # J, of 0.2; measured 7e-15


def test_a_wheel_that_stands_on_two_barrels_stays():
    """Between two barrels a hub is lowest: both carry half, and friction lets it stay there."""
    data = turned_wheels(kiwi(), 18.0)
    barrel = {"kind": "arc", "radius": 0.0095, "curvature_radius": 0.045, "half_length": 0.01}
    data["wheel_types"]["omni"] = OMNI | {"contact": {"stiffness": STIFFNESS, "damping": 100.0}, "profile": barrel}
    data |= {"friction": {"law": "regularized", "coefficient": 0.5, "slip_speed": 0.2}}
    motion = run(data, "time={end=0.2, step=5e-5, output_interval=0.01}")
    assert np.abs(of_wheels(motion, "contact_share") - 0.5).max() < 1e-11  # measured 3e-14
    assert np.abs(motion["body/velocity"]).max() < 1e-12  # m/s; measured 2e-15
    assert np.abs(of_wheels(motion, "normal_force") / (whole_mass(data) * G / 3.0) - 1.0).max() < 1e-11


def test_wheels_that_land_or_leave_at_one_instant_do_so_in_one_change():
    """Of five right-hand sides: four of the step that goes too far, one for what is new."""
    data = free(machine("omni"))
    motion = run(data | {"initial": {"height": 2e-3}, "time": {"end": 0.1, "step": 1e-5, "output_interval": 1e-3}})
    assert list(motion["events/kind"]).count("touch_down") == 8  # four wheels land twice, and leave twice
    beside = motion.attributes["rhs_evaluations"] - 4 * motion.attributes["steps"]
    assert beside == 4 * 5 + 2  # two at the start find the contacts and the derivative


def on_bumps(height: float, beyond: float) -> dict:
    """Three wheels, each on a bump whose top lies so far beyond the wheel from the middle of the machine, m."""
    away = 1.0 + beyond / 0.2
    data = kiwi() | {"floor": {"bumps": [[x * away, y * away, height, 0.1] for x, y in TRIANGLE]}}
    data["wheel_types"]["omni"] = OMNI | {"contact": {"stiffness": STIFFNESS, "damping": 100.0}}
    return data | {"friction": {"law": "regularized", "coefficient": 0.5, "slip_speed": 0.1}}


@pytest.mark.parametrize("height", [60.0, -60.0])
def test_a_machine_begins_on_the_ground_below_it_however_high_the_rest_is(height):
    """More than a thousand wheel radii: a hill or a pit far away, and the machine in its middle."""
    data = kiwi()
    level = rest(data)[0].height
    away = rest(data | {"floor": {"bumps": [[800.0, 0.0, height, 20.0]]}})[0]
    assert abs(away.height / level - 1.0) < 1e-11  # measured 5e-14
    amid = rest(data | {"floor": {"bumps": [[0.0, 0.0, height, 100.0]]}})[0]
    assert abs(amid.height - height * np.exp(-4e-6) - level) < 1e-7  # m, by the slope beside the top; measured 2.7e-8


def test_ground_without_an_end_carries_nothing():
    with pytest.raises(ConfigError, match="nothing carries it"):
        rest(kiwi() | {"floor": {"bumps": [[0.5, 0.0, 1e200, 0.1]]}})


def test_a_machine_without_weight_begins_where_it_touches_the_ground():
    data = kiwi() | {"scene": {"upright": "free", "gravity": 0.0}}
    assert rest(data)[0].height == 0.0
    pose, loads = rest(data | {"floor": {"bumps": [[*TRIANGLE[0], 0.02, 0.1]]}})
    assert abs(pose.height - 0.02) < 1e-14 and pose.roll == pose.pitch == 0.0  # m; measured 4e-16
    assert not loads.any()


@pytest.mark.parametrize("height", [0.01, -0.01])
def test_a_machine_on_the_tops_of_bumps_or_the_bottoms_of_pits_stays(height):
    motion = run(on_bumps(height, 0.0), "time={end=0.2, step=5e-5, output_interval=0.01}")
    moved = motion["body/position"] - motion["body/position"][0]
    assert np.abs(moved).max() < 1e-13  # m; measured 1.2e-14
    assert np.abs(motion["body/velocity"]).max() < 1e-11  # m/s; measured 8.8e-13: rounding that grows, it may roll off


@pytest.mark.parametrize("height", [0.01, -0.01])
def test_a_machine_on_flanks_begins_to_sink_by_what_friction_does_not_hold_at_rest(height):
    """Placed as if forces were vertical it has N = M g cos / 3 of each wheel, smooth friction none at zero slip: of
    N along the normal gravity is left with g sin^2 of the slope there."""
    data = on_bumps(height, 0.02)
    thickness, load, tilt = OMNI["radius"] - OMNI["roller_distance"], whole_mass(data) * G / 3.0, 0.0
    for _ in range(50):
        off = 0.02 - (thickness - load * np.cos(tilt) / STIFFNESS) * np.sin(tilt)  # of the contact below the top
        tilt = np.arctan(2.0 * height * off / 0.01 * np.exp(-off * off / 0.01))
    motion = run(data, "time={end=1e-5, step=1e-6, output_interval=1e-5}")
    found = motion["body/velocity"][-1, 2] / 1e-5
    assert abs(found / (-G * np.sin(tilt) ** 2) - 1.0) < 1e-3  # measured 3.2e-4, by the time of 1e-5 s
