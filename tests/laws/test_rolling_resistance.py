"""Rolling resistance: coasting in closed form ahead and aside, energy, rest on two rollers, what it needs of a step."""

import numpy as np
import pytest
from machines import axle_inertia, machine, run, scene, tables
from scenes import final_state, of_wheels, reference_scene

import omnisim
from omnisim.dynamics.packing import pack
from omnisim.march.stiffness import explanation, relaxation_rate

G, LENGTH, RATE = 9.81, 8e-4, 0.1
COULOMB = {"law": "coulomb", "coefficient": 0.8}
COAST = {"end": 1.0, "step": 1e-3, "output_interval": 0.02}


def resisting(data, length=LENGTH, rate=RATE):
    """The scene with rollers that resist rolling."""
    kinds = data["wheel_types"]
    own = {"rolling_resistance": length, "rolling_rate": rate}
    return data | {"wheel_types": {name: kind | {"roller": kind["roller"] | own} for name, kind in kinds.items()}}


def left(w, rate=RATE):
    """What falls linearly in time while w' = -A w / sqrt(w^2 + r^2)."""
    return np.sqrt(w * w + rate * rate) - rate * np.arcsinh(rate / w)


@pytest.mark.parametrize("formulation", ["reduced", "multibody"])
@pytest.mark.parametrize("upright", ["servo", "contacts"])
def test_a_machine_that_rolls_ahead_loses_f_g_m_by_its_effective_mass_and_radius(upright, formulation):
    """V' = -f g M / (M + 4 J / R^2) / R while it is fast, whoever carries which load."""
    data = machine("omni", friction=COULOMB, scene={"upright": upright}, time=COAST | {"end": 2.0})
    radius, speed = data["wheel_types"]["omni"]["radius"], 0.6
    mass = pack(scene(data).config).machine.mass
    for wheel in data["wheels"]:
        wheel["spin_rate"] = speed / radius
    data = resisting(data, 4e-3, 0.5) | {"initial": {"velocity": [speed, 0.0]}, "solver": {"formulation": formulation}}
    coasting = run(data)
    slowing = 4e-3 * G * mass / (mass + 4.0 * axle_inertia("omni") / radius**2) / radius**2
    spins = of_wheels(coasting, "spin_rate")
    expected = left(speed / radius, 0.5) - slowing * coasting.time[:, None]
    assert spins[-1].max() < 1.0 and (coasting["events/kind"] == "exchange").sum() > 4
    rolling = coasting.time < 1.3  # s; then it has slowed to 1e-3 rad/s, whose logarithm has few digits
    assert spins[rolling].min() < 0.1
    assert np.abs(left(spins, 0.5) - expected)[rolling].max() < 1e-8  # rad/s, of 9.6
    assert np.abs(coasting["body/velocity"][:, 0] - radius * spins[:, 0]).max() < 1e-11  # m/s; measured 2e-12
    lost = coasting["energy/kinetic"][0] - coasting["energy/kinetic"]
    assert np.abs(coasting["energy/rolling_loss"] - lost).max() < 1e-10 * lost[-1]


def turning(data, angle):
    """|w_t| by the speed (1/m) of 45 deg wheels that roll without slip at this angle from ahead, the mean over the way
    on a roller; wheels of one sense, those of the other at -angle.

    Spin by speed (cos - sin / cos q) / R, and the roller's own rate sin / (h_q c cos q).
    """
    kind = data["wheel_types"]["mecanum"]
    radius, distance = kind["radius"], kind["roller_distance"]
    q = np.linspace(-1.0, 1.0, 20001) * np.pi / kind["roller_count"]
    h_q, c = radius - distance / np.cos(q), np.cos(np.pi / 4)
    spin = (np.cos(angle) - np.sin(angle) / np.cos(q)) / radius
    joint = np.sin(angle) / (h_q * c * np.cos(q))
    return np.average(np.hypot(joint * c * np.cos(q), spin + joint * c), weights=1.0 / np.abs(spin))


@pytest.mark.parametrize("angle_deg", [0.0, 90.0, 180.0, -90.0])
def test_a_mecanum_machine_loses_what_its_rollers_and_wheels_turn_on_the_floor(angle_deg):
    """Of light rollers, which take up little on the floor, and under so little of it that the speed hardly changes."""
    angle, speed = np.radians(angle_deg), 0.5
    data = machine("mecanum", friction=COULOMB, time=COAST)
    velocity = speed * np.array([np.cos(angle), np.sin(angle)])
    for wheel in data["wheels"]:
        slant = -1.0 if wheel["mirrored"] else 1.0
        wheel["spin_rate"] = (velocity[0] - slant * velocity[1]) / data["wheel_types"]["mecanum"]["radius"]
    data = resisting(data, 1e-6) | {"initial": {"velocity": velocity.tolist()}}
    data["wheel_types"]["mecanum"]["roller"]["inertia_axial"] = 1e-9
    coasting = run(data, "time.end=2.0")
    way = np.hypot(*np.diff(coasting["body/position"][:, :2], axis=0).T).sum()
    weight = G * pack(scene(data).config).machine.mass
    expected = 1e-6 * weight * way * np.mean([turning(data, angle), turning(data, -angle)])
    assert coasting["energy/rolling_loss"][-1] == pytest.approx(expected, rel=2e-3)
    assert (coasting["events/kind"] == "exchange").sum() > 10


MACHINES = {
    "a wheel that slips": ("testbench_psi30", ("time.end=1.0", "time.step=2e-4"), "omni"),
    "a wheel that slips and sticks": ("coulomb_wheel", ("time.step=1e-3", "solver.method=auto"), "omni"),
    "four mecanum wheels": ("mecanum", ("time.end=0.5", "time.step=2e-5"), "mecanum"),
    "three wheels in space": ("spatial_kiwi_slope", ("time.end=0.2", "time.step=2e-5"), "type0"),
}


@pytest.mark.parametrize("name", MACHINES)
def test_rolling_resistance_turns_motion_into_heat_and_nothing_else(name):
    reference, overrides, kind = MACHINES[name]
    roller = f"wheel_types.{kind}.roller"
    own = (f"{roller}.rolling_resistance=1e-3", f"{roller}.rolling_rate=1.0")
    motion = omnisim.simulate(reference_scene(reference, *overrides, *own))
    assert motion.complete, motion.attributes["status"]
    loss = motion["energy/rolling_loss"]
    assert np.diff(loss).min() >= 0.0 and loss[-1] > 1e-3
    assert np.abs(motion["energy/balance"]).max() < 1e-6 * loss[-1]


@pytest.mark.parametrize("law", ["regularized", "coulomb"])
def test_rk4_keeps_its_order(law):
    own = ("friction.law=" + law, "wheel_types.omni.roller.rolling_resistance=2e-3", "time.end=0.6",
           "time.output_interval=0.6", "wheel_types.omni.roller.rolling_rate=2.0")  # fmt: skip
    finest = omnisim.simulate(reference_scene("testbench_psi30", *own, "solver.method=dopri5", "time.step=2.5e-5"))
    errors = []
    for step in (8e-4, 4e-4, 2e-4):
        motion = omnisim.simulate(reference_scene("testbench_psi30", *own, f"time.step={step}"))
        errors.append(np.abs(final_state(motion) - final_state(finest)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.min() > 3.8, (errors, orders)


# standing on an edge, twisted: each roller alone would roll the wheel onto the other
TWISTED = (
    "initial={velocity=[0.0, 0.0], yaw_rate=0.0}", "wheels.wheel.spin_rate=0.0", "wheels.wheel.spin_angle_deg=45",
    "wrench={times=[0.0, 0.2], force=[[0.0, 0.5, 1.0], [0.0, 0.2, -3.0]], yaw_torque=[0.3, 0.4]}",
    "time={end=0.2, step=2e-4, output_interval=0.01}", "solver.method=radau5",
)  # fmt: skip
ROLLER = ("wheel_types.omni.roller.rolling_resistance=1e-3", "wheel_types.omni.roller.rolling_rate=0.5")


def test_on_two_rollers_the_share_under_coulomb_friction_is_the_limit_of_regularized_ones():
    """Smooth shares agree with the oracle, oracle/test_shared_contact.py."""

    def shares(*overrides):
        motion = omnisim.simulate(reference_scene("testbench_psi30", *TWISTED, *overrides))
        assert motion.complete, motion.attributes["status"]
        return motion["wheels/wheel/contact_share"][2:]

    share = shares("friction.law=coulomb", *ROLLER)
    laws = [("friction.law=regularized", f"friction.slip_speed={speed}") for speed in (1e-3, 1e-4, 1e-5)]
    errors = [np.abs(shares(*law, *ROLLER) - share).max() for law in laws]
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all((ratios > 5.0) & (ratios < 20.0)), errors  # first order in the slip speed
    assert np.abs(shares("friction.law=coulomb") - share).max() > 100.0 * errors[-1]


def test_the_rate_at_which_it_stops_a_roller_is_told_and_steps_too_long_for_it_end_the_run():
    """f N / r (1 / Ia + 1 / J) at a standstill."""
    data = resisting(tables(reference_scene("kiwi")), 2e-3, 1e-2)
    told = scene(data)
    parameters = pack(told.config)
    [kind] = data["wheel_types"].values()
    heaviest = relaxation_rate(told.config, parameters) / (2e-3 / 1e-2) * kind["roller"]["inertia_axial"]
    assert 0.9 < heaviest / (parameters.machine.mass * G / 3.0) < 1.3
    assert "relaxes" in explanation(told.config, parameters)
    data["initial"] = {"velocity": [0.0, 0.0], "yaw_rate": 0.0}
    for wheel in data["wheels"]:
        wheel |= {"spin_rate": 0.0, "roller_rates": 0.0}
    stopped = omnisim.simulate(scene(data, "solver.method=rk4", "time.step=1e-3", "time.output_interval=1e-2"))
    assert "too fast for rk4" in stopped.attributes["status"] and "rolling_rate" in stopped.attributes["status"]


@pytest.mark.short
def test_without_it_no_file_tells_of_it():
    motion = omnisim.simulate(reference_scene("testbench_psi0", "time.end=0.01", "time.output_interval=0.01"))
    assert "energy/rolling_loss" not in motion
