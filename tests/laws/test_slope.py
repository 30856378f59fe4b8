"""Inclined floors against closed forms: falling, rolling, holding, creeping, sliding, tipping.

S: the slope, towards uphill_deg. Wheels are locked by rotors of 1e4 kg m^2 in their motors. Measured values stand
beside the bounds.
"""

import numpy as np
import pytest
from machines import BOX, CHASSIS, TYPES, axle_inertia, locked, machine, on_slope, run, scene, tables, wheel_mass
from scenes import of_wheels, reference_scene, simulate

import omnisim
from omnisim.dynamics.packing import bodies, pack
from omnisim.dynamics.static_loads import static_loads

G = 9.81
MU = 0.5
COULOMB = {"law": "coulomb", "coefficient": MU}


def speed(motion) -> np.ndarray:
    return np.linalg.norm(motion["body/velocity"][:, :2], axis=1)


@pytest.mark.parametrize("formulation", ["reduced", "multibody"])
def test_without_friction_everything_falls_alike_and_keeps_its_energy(formulation):
    """The centre of mass of a turning machine flies along the parabola of g sin S; kinetic + gravity is constant."""
    offset = CHASSIS | {"center_of_mass": [0.05, -0.04, 0.12]}
    initial = {"velocity": [0.3, 0.6], "yaw_rate": 1.5}
    data = on_slope(machine("mecanum", chassis=offset, initial=initial), 0.3, 50.0) | {
        "solver": {"formulation": formulation},
        "time": {"end": 0.5, "step": 1e-3, "output_interval": 0.05},
    }
    motion, whole = run(data), bodies(scene(data).config)
    yaw, (x, y, _) = motion["body/yaw"], whole.centre
    cos, sin = np.cos(yaw), np.sin(yaw)
    centre = motion["body/position"][:, :2] + np.stack([x * cos - y * sin, x * sin + y * cos], axis=1)
    start = np.array([0.3, 0.6]) + 1.5 * np.array([-y, x])
    down = -G * np.sin(0.3) * np.array([np.cos(np.radians(50.0)), np.sin(np.radians(50.0))])
    expected = [x, y] + np.outer(motion.time, start) + 0.5 * np.outer(motion.time**2, down)
    assert np.abs(centre - expected).max() < 1e-13  # m
    bound = 1e-12 if formulation == "reduced" else 1e-8  # measured 4e-15 and 3e-9: there rk4 turns bodies in space
    assert np.abs(yaw - 1.5 * motion.time).max() < bound
    energy = motion["energy/kinetic"] + motion["energy/gravity"]
    assert np.abs(energy - energy[0]).max() < bound  # J, of 20
    height = centre @ -down / G + whole.centre[2] * np.cos(0.3)  # above the world's origin
    assert np.abs(motion["energy/gravity"] - whole.mass * G * height).max() < 1e-12
    assert np.abs(of_wheels(motion, "normal_force").sum(axis=1) - whole.mass * G * np.cos(0.3)).max() < 1e-12
    assert np.abs(motion["energy/balance"]).max() < bound


def test_a_wheel_rolls_down_with_its_axle_inertia_and_across_with_that_of_one_roller():
    """psi = 0: a = g sin S m / (m + J_k / R^2) downhill; across, the roller below rolls: m / (m + Ia / (R - R1)^2)."""
    mass, slope = 0.5 + 6 * 0.03, np.radians(10.0)
    inertia = 4e-4 + 6 * (0.03 * 0.04**2 + 9e-6)
    still = ("friction={law='coulomb', coefficient=0.5}", "initial={}", "wheels.wheel.spin_rate=0.0",
             "wheels.wheel.roller_rates=0.0", "wheels.wheel.spin_angle_deg=0.0", "time.end=0.5",
             "floor.slope_deg=10.0")  # fmt: skip
    down = simulate("testbench_psi0", *still, "floor.uphill_deg=180.0")
    expected = G * np.sin(slope) * mass / (mass + inertia / 0.05**2)
    assert np.abs(down["body/acceleration"] - [expected, 0.0, 0.0]).max() < 1e-12
    assert "exchange" in down["events/kind"]
    assert np.abs(down["energy/balance"]).max() < 1e-12
    across = simulate("testbench_psi0", *still, "floor.uphill_deg=90.0")
    expected = -G * np.sin(slope) * mass / (mass + 6e-6 / 0.01**2)
    assert np.abs(across["body/acceleration"] - [0.0, expected, 0.0]).max() < 1e-12


def test_a_mecanum_machine_rolls_down_as_four_wheels_and_their_lowest_rollers():
    """a = g sin S M / (M + 4 (J_k + Ia sin^2 psi) / R^2) until rollers change: the next ones do not turn yet."""
    slope, kind = np.radians(8.0), TYPES["mecanum"]
    data = on_slope(machine("mecanum", friction=COULOMB), slope, 180.0)
    motion, mass = run(data, "time.end=0.3"), CHASSIS["mass"] + 4 * wheel_mass("mecanum")
    turning = axle_inertia("mecanum") + 0.5 * kind["roller"]["inertia_axial"]
    expected = G * np.sin(slope) * mass / (mass + 4 * turning / kind["radius"] ** 2)
    before = motion.time < motion["events/time"][motion["events/kind"] == "exchange"].min()
    assert before.sum() > 10
    assert np.abs(motion["body/acceleration"][before, 0] - expected).max() < 1e-12


def limit(uphill_deg: float, mu: float = MU) -> float:
    """tan S* of four locked mecanum wheels, each of which holds along its roller's axis only."""
    return mu / (2.0 * max(abs(np.cos(np.radians(uphill_deg + side))) for side in (-45.0, 45.0)))


@pytest.mark.parametrize("uphill_deg", [0.0, 30.0, 45.0, 90.0])
def test_four_locked_mecanum_wheels_hold_to_their_limit_and_no_further(uphill_deg):
    """tan S* = mu / (2 max |cos(U +- 45 deg)|): a thousandth below, the machine stands; above, it slides."""
    data, time = locked(machine("mecanum", friction=COULOMB)), "time={end=0.2, step=1e-3, output_interval=0.02}"
    stands = run(on_slope(data, np.arctan(0.999 * limit(uphill_deg)), uphill_deg), time)
    assert speed(stands).max() < 1e-6  # m/s; measured 4e-7, what the rotors give way
    slides = run(on_slope(data, np.arctan(1.001 * limit(uphill_deg)), uphill_deg), time)
    assert speed(slides)[-1] > 1e-4


def test_locked_mecanum_wheels_slide_down_with_what_friction_leaves():
    """M a = M g sin S - sum of friction. Across its axis it speeds a roller up, with Ia / (R - R1)^2 as its mass."""
    slope, kind = np.arctan(1.3 * limit(0.0)), TYPES["mecanum"]
    motion = run(on_slope(locked(machine("mecanum", friction=COULOMB)), slope), "time.end=0.2")
    mass, loads = CHASSIS["mass"] + 4 * wheel_mass("mecanum"), of_wheels(motion, "normal_force")
    roller = kind["roller"]["inertia_axial"] / (kind["radius"] - kind["roller_distance"]) ** 2
    down = -motion["body/acceleration"][1:, 0]
    across = along = np.zeros_like(loads[1:])  # of mu N; slip has the same direction, and grows
    for _ in range(10):
        along = np.sqrt((MU * loads[1:]) ** 2 - across**2)
        across = roller * down[:, None] / np.sqrt(2.0) * (1.0 - across / along)
    friction = along + across
    residual = mass * G * np.sin(slope) - friction.sum(axis=1) / np.sqrt(2.0) - mass * down
    assert np.abs(residual).max() < 1e-7  # N, of 20
    without = G * np.cos(slope) * (np.tan(slope) - limit(0.0))
    assert np.abs(down / without - 1.0).max() < 0.02  # g cos S (tan S - tan S*) but for the rollers


def test_regularized_friction_creeps_below_the_limit():
    """At sqrt 2 eps rho / sqrt(1 - rho^2), rho = tan S / tan S*."""
    rho, eps = 0.6, 0.05
    friction = {"law": "regularized", "coefficient": MU, "slip_speed": eps}
    time = {"end": 1.0, "step": 1e-4, "output_interval": 0.1}
    data = locked(machine("mecanum", friction=friction, time=time), rotor=1e9)
    creeping = run(on_slope(data, np.arctan(rho * limit(0.0))))
    expected = np.sqrt(2.0) * eps * rho / np.sqrt(1.0 - rho**2)
    assert abs(-creeping["body/velocity"][-1, 0] / expected - 1.0) < 1e-8


def test_a_locked_kiwi_holds_to_its_limit():
    """Uphill ahead its two front wheels hold, with the load that the slope leaves them:
    tan S* = (mu / 3) / (1 / sqrt 3 + mu z_C / (3 r))."""
    data = locked(tables("kiwi")) | {"friction": COULOMB}
    height, time = bodies(scene(data).config).centre[2], "time={end=0.1, step=1e-3, output_interval=0.01}"
    steepest = (MU / 3.0) / (1.0 / np.sqrt(3.0) + MU * height / 0.375)
    stands, slides = (run(on_slope(data, np.arctan(part * steepest)), time) for part in (0.999, 1.001))
    assert speed(stands).max() < 1e-6
    assert speed(slides)[-1] > 1e-4


def test_the_wheels_uphill_lose_load_until_the_machine_tips():
    """N_up / N_0 = 1 - tan S / tan S_tip, tan S_tip = b / z_C; beyond it the run stops, and says so."""
    data = locked(machine("omni", friction=COULOMB | {"coefficient": 5.0}))
    whole, time = bodies(scene(data).config), "time={end=0.02, step=1e-3, output_interval=0.01}"
    steepest = BOX[0][0] / whole.centre[2]
    for part in (0.2, 0.7, 0.999):
        slope = np.arctan(part * steepest)
        motion = run(on_slope(data, slope), time)
        level = whole.mass * G * np.cos(slope) / 4.0
        ratios = of_wheels(motion, "normal_force") / level
        assert np.abs(ratios - [1.0 - part, 1.0 - part, 1.0 + part, 1.0 + part]).max() < 1e-5, part
    tipping = omnisim.simulate(scene(on_slope(data, np.arctan(1.001 * steepest)), time))
    assert not tipping.complete
    assert "w0" in tipping.attributes["status"] or "w1" in tipping.attributes["status"]


def test_loads_at_standstill_are_those_of_the_slope():
    """A machine that stands askew on a slope, held by locked wheels: what statics says is what the run finds."""
    data = locked(machine("mecanum", friction=COULOMB, initial={"yaw_deg": 25.0},
                          chassis=CHASSIS | {"center_of_mass": [0.03, -0.02, 0.12]}))  # fmt: skip
    data = on_slope(data, np.radians(6.0), 70.0)
    found = of_wheels(run(data, "time.end=0.01"), "normal_force")[0]
    expected = static_loads(pack(scene(data).config), yaw=np.radians(25.0))
    assert np.abs(found - expected).max() < 1e-5  # N, of 20


def test_a_slope_is_one_motion_by_every_way_to_compute_it():
    """An implicit method, both trackings, a controller's loop, and a step that is picked."""
    time = "time={end=0.5, step=2e-4, output_interval=0.1}"
    plain = reference_scene("kiwi", "floor={slope_deg=7.0, uphill_deg=40.0}", time)
    motion = omnisim.simulate(plain)
    for override in ("solver.method=radau5", "solver.tracking=implicit", "solver.error=1e-8"):
        other = omnisim.simulate(omnisim.load_text(plain.text, [override]))
        assert other.complete and len(other.time) == 6
        assert np.abs(other["body/position"] - motion["body/position"]).max() < 1e-8, override
    loop = omnisim.Loop(plain)
    while loop.advance(0.1):
        pass
    assert np.array_equal(loop.trajectory()["energy/gravity"], motion["energy/gravity"])
    assert "energy/gravity" not in omnisim.simulate(reference_scene("kiwi", time))


def test_a_machine_that_stands_far_away_on_a_slope_stands():
    """Its weight does no work but in rounding of its place, which is no energy from nowhere."""
    data = on_slope(machine("omni", friction=COULOMB), np.radians(5.0), 90.0)
    data["wheels"] = [wheel | {"heading_deg": 90.0} for wheel in data["wheels"]]
    force = G * np.sin(np.radians(5.0)) * (CHASSIS["mass"] + 4 * wheel_mass("omni")) / 4
    for wheel in data["wheels"]:
        wheel["drive"] = {"kind": "torque", "torque": force * TYPES["omni"]["radius"]}
    stands = run(data | {"initial": {"position": [1234.5, -987.6]}})
    assert speed(stands).max() < 1e-9
