"""Motors against closed forms: a wheel without friction of the floor spins by its motor alone, J phi'' = tau.

L I' = V - K phi' - R I, tau = K I - b phi' with K = g k; J is that of the wheel with the rotor.
"""

import numpy as np
import pytest
from machines import axle_inertia, machine, run, scene
from scipy.linalg import expm
from scipy.optimize import brentq

import omnisim
from omnisim.dynamics.packing import pack
from omnisim.march.stiffness import explanation
from omnisim.run.step_search import candidates
from omnisim.run.work_precision import ladder
from omnisim.scene.drives import drive_law

GEAR, RESISTANCE = 14.0, 1.2
K, B = GEAR * 0.015, 2e-3  # V s/rad, N m s
MOTOR = {"kind": "dc_motor", "resistance": RESISTANCE, "torque_constant": 0.015, "gear_ratio": GEAR, "viscosity": B,
         "rotor_inertia": 3e-6}  # fmt: skip
J = axle_inertia("mecanum") + GEAR**2 * 3e-6
SHEET = {"nominal_voltage": 24.0, "stall_torque": 0.49, "stall_current": 20.0, "no_load_speed": 950.0,
         "no_load_current": 0.4}  # fmt: skip


def spin_of(drive, *overrides, **wheel):
    """Trajectory of a machine on four wheels of which the first has this drive; its spin rate, voltage and current."""
    data = machine("mecanum", drives=[drive])
    data["wheels"][0] |= wheel
    trajectory = run(data, "time.end=0.2", *overrides)
    assert not trajectory["body/velocity"].any(), "the others do not notice"
    return trajectory, *(trajectory[f"wheels/w0/{name}"] for name in ("spin_rate", "voltage", "current"))


def linear(matrix, start, end, times):
    """State of x' = matrix (x - end) from x = start, (T, n)."""
    return np.array([end + expm(np.array(matrix) * t) @ (np.array(start) - end) for t in times])


def test_a_controlled_motor_approaches_its_target_as_a_linear_system():
    """x = (phi', z): J phi'' = K (V - K phi') / R - b phi', V = kp (u - phi') + ki z, z' = u - phi'."""
    kp, ki, u = 0.8, 6.0, 12.0
    drive = MOTOR | {"rate": u, "proportional": kp, "integral": ki}
    trajectory, rate, voltage, _ = spin_of(drive, "time.step=1e-4")
    matrix = [[-(K * (K + kp) / RESISTANCE + B) / J, K * ki / RESISTANCE / J], [-1.0, 0.0]]
    end = np.array([u, (K * u + B * u * RESISTANCE / K) / ki])
    expected = linear(matrix, [0.0, 0.0], end, trajectory.time)
    assert np.abs(rate - expected[:, 0]).max() < 1e-8  # rad/s, of 12; measured 6e-10
    assert np.abs(voltage - kp * (u - expected[:, 0]) - ki * expected[:, 1]).max() < 1e-8  # V
    assert np.all(trajectory["wheels/w0/target_rate"] == u)


def test_a_current_rises_in_its_inductance():
    """A wheel on a constant voltage, x = (phi', I); its first millisecond is that of R and L alone."""
    inductance, volts = 4e-3, 6.0
    trajectory, rate, _, current = spin_of(MOTOR | {"voltage": volts, "inductance": inductance}, "time.step=1e-4")
    matrix = np.array([[-B / J, K / J], [-K / inductance, -RESISTANCE / inductance]])
    end = -np.linalg.solve(matrix, [0.0, volts / inductance])
    expected = linear(matrix, [0.0, 0.0], end, trajectory.time)
    assert np.abs(np.column_stack([rate, current]) - expected).max() < 1e-8  # measured 5e-9
    blocked = spin_of(MOTOR | {"voltage": volts, "inductance": inductance, "rotor_inertia": 1.0}, "time.step=5e-4")[3]
    rising = volts / RESISTANCE * -np.expm1(-RESISTANCE / inductance * trajectory.time)
    assert np.abs(blocked - rising).max() < 1e-3  # A, of 5: the heavy rotor hardly turns; measured 2e-4


@pytest.mark.parametrize("limits", ["voltage", "current"])
def test_a_motor_leaves_its_limit_at_the_right_time_and_the_order_survives(limits):
    """At a constant voltage or current until the demand kp (u - phi') falls below it; then a linear system."""
    kp, u, most = 0.5, 15.0, 4.0
    drive = MOTOR | {"rate": u, "proportional": kp} | {f"{limits}_limit": most}
    slope = K / RESISTANCE / J
    torque, pace = (slope * most, K * slope + B / J) if limits == "voltage" else (K * most / J, B / J)
    end = torque / pace  # rate that the limit alone would reach
    leaves = brentq(
        lambda t: kp * (u - end * -np.expm1(-pace * t))
        - (most if limits == "voltage" else RESISTANCE * most + K * end * -np.expm1(-pace * t)), 0.0, 1.0, xtol=1e-15,
    )  # fmt: skip
    after, errors = (K + kp) * slope + B / J, []
    for step in (2e-3, 1e-3, 5e-4):
        trajectory, rate, voltage, current = spin_of(drive, f"time.step={step}", "time.output_interval=0.002")
        t, limited = trajectory.time, trajectory.time < leaves
        steady, at = kp * u * slope / after, end * -np.expm1(-pace * leaves)
        then = steady + (at - steady) * np.exp(-after * np.maximum(t - leaves, 0.0))
        errors.append(np.abs(rate - np.where(limited, end * -np.expm1(-pace * t), then)).max())
        held = voltage if limits == "voltage" else current
        assert np.abs(held[limited] - most).max() < 1e-12 and np.all(held[~limited] < most)
    assert 0.006 < leaves < 0.02 and errors[-1] < 1e-6  # rad/s, of 12; measured 4e-8, 8e-8
    assert np.log2(errors[0] / errors[-1]) / 2 >= 3.7, errors  # measured 4.07, 4.01


def test_a_demand_that_jumps_goes_from_one_limit_to_the_other():
    """Reversal at full speed: the current is kept first, and the voltage bounds what keeps it."""
    drive = MOTOR | {"times": [0.0, 0.1, 0.1], "rate": [28.0, 28.0, -28.0], "proportional": 5.0, "voltage_limit": 6.0,
                     "current_limit": 3.0}  # fmt: skip
    trajectory, rate, voltage, current = spin_of(drive, "time.step=1e-3")
    at = dict(zip(np.round(trajectory.time, 6).tolist(), range(len(rate)), strict=True))
    assert current[0] == 3.0 and voltage[at[0.09]] == 6.0 and current[at[0.09]] < 3.0
    assert current[at[0.1]] == -3.0 and np.abs(voltage).max() <= 6.0 * (1 + 1e-11)
    assert np.abs(current).max() <= 3.0 * (1 + 1e-11)


def test_back_driven_beyond_its_voltage_a_motor_gives_what_it_cannot_keep():
    """A rotor at three times the speed that the limit is good for: the current limit asks for more than the supply."""
    drive = MOTOR | {"rate": 0.0, "proportional": 5.0, "voltage_limit": 2.0, "current_limit": 1.0}
    _, rate, voltage, current = spin_of(drive, "time.step=1e-3", spin_rate=40.0)
    assert voltage[0] == 2.0 and current[0] == pytest.approx((2.0 - K * 40.0) / RESISTANCE, rel=1e-12)
    assert current[-1] == pytest.approx(-1.0, rel=1e-9) or rate[-1] < 5.0


def test_with_an_inductance_the_current_nears_its_limit_and_never_passes_it():
    drive = MOTOR | {"rate": 25.0, "proportional": 5.0, "voltage_limit": 12.0, "current_limit": 3.0, "inductance": 4e-3}
    trajectory, _, _, current = spin_of(drive, "time.step=1e-4", "time.output_interval=1e-3")
    early = trajectory.time < 0.03
    rising = 3.0 * -np.expm1(-RESISTANCE / 4e-3 * trajectory.time)
    assert np.abs(current - rising)[early].max() < 1e-8  # A; measured 8e-9
    assert current.max() < 3.0


@pytest.mark.parametrize(("ki", "kd", "limit"), [(0.0, 0.0, np.inf), (8.0, 2e-3, np.inf), (8.0, 0.0, 5.0)])
def test_a_sampled_controller_is_its_recursion(ki, kd, limit):
    """Between samples V is held: phi'_n+1 = a phi'_n + c V_n, exactly; V_n from the rate read then, z by its sum."""
    kp, u, period = 0.6, 14.0, 0.005
    drive = MOTOR | {"rate": u, "proportional": kp, "integral": ki, "derivative": kd, "sample_time": period}
    drive |= {"voltage_limit": limit} if np.isfinite(limit) else {}
    trajectory, rate, voltage, _ = spin_of(drive, "time.step=2.5e-4", "time.output_interval=0.005")
    pace = (K**2 / RESISTANCE + B) / J
    a, c = np.exp(-pace * period), K / RESISTANCE / J / pace * -np.expm1(-pace * period)
    speed, before, z, expected = 0.0, 0.0, 0.0, []
    for _ in trajectory.time:
        demand = kp * (u - speed) + ki * z - kd * (speed - before) / period
        given = min(max(demand, -limit), limit)
        expected.append((speed, given))
        z += period * (u - speed + (given - demand) / kp)
        speed, before = a * speed + c * given, speed
    assert np.abs(np.column_stack([rate, voltage]) - expected).max() < 1e-9  # measured 8e-11 to 1.1e-10
    fine = spin_of(drive, "time.step=2.5e-4", "time.output_interval=0.001")[2]
    held = fine[:-1].reshape(-1, 5)
    assert np.abs(held - held[:, :1]).max() == 0.0


@pytest.mark.parametrize("extra", [{}, {"inductance": 4e-3}, {"current_limit": 2.0}, {"sample_time": 0.01}])
def test_what_the_supply_gives_is_work_heat_friction_and_field(extra):
    """electrical = motor_work + heat + motor_loss + magnetic; the balance has it with the motion, at fourth order."""
    drive = MOTOR | {"rate": 15.0, "proportional": 0.8, "integral": 4.0, "friction_torque": 0.01, "friction_rate": 1.0}
    errors = []
    for step in (4e-4, 2e-4):
        trajectory, *_ = spin_of(drive | extra, f"time.step={step}", "time.output_interval=0.01")
        energy = {name: trajectory[f"energy/{name}"] for name in
                  ("electrical", "heat", "motor_loss", "motor_work", "magnetic", "drive_work", "kinetic")}  # fmt: skip
        left = energy["motor_work"] + energy["heat"] + energy["motor_loss"] + energy["magnetic"] - energy["electrical"]
        errors.append(np.abs(trajectory["energy/balance"]).max())
        assert np.abs(left).max() < (1e-13 if "inductance" not in extra else 1e-6)  # J: linear in the same stages
        assert np.array_equal(energy["motor_work"], energy["drive_work"])
    power, heat, current = (trajectory[f"wheels/w0/{name}"] for name in ("electrical_power", "heat", "current"))
    assert np.array_equal(heat, RESISTANCE * current**2)
    assert np.array_equal(power, trajectory["wheels/w0/voltage"] * current)
    assert energy["electrical"][-1] > 0.1 and energy["motor_loss"][-1] > 1e-3
    assert errors[-1] < 1e-6 and np.log2(errors[0] / errors[1]) >= 3.7, errors  # measured 4.01 to 4.03


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
def test_both_formulations_move_a_machine_on_motors_alike(tracking):
    drive = MOTOR | {"rate": 6.0, "proportional": 0.8, "integral": 4.0, "inductance": 4e-3, "current_limit": 2.0,
                     "voltage_limit": 3.0}  # fmt: skip
    data = machine("mecanum", drives=[drive | {"sample_time": 2e-3}, drive, drive, drive], friction=ROUGH)
    short = ("time.end=0.02", "time.step=1e-4", f"solver.tracking={tracking}")
    reduced, multibody = (run(data, *short, f"solver.formulation={f}") for f in ("reduced", "multibody"))
    for path in ("body/position", "body/velocity", *(f"wheels/w{w}/{q}" for w in (0, 1) for q in QUANTITIES)):
        assert np.abs(reduced[path] - multibody[path]).max() < 1e-9, path  # measured 4e-12, the voltage


QUANTITIES = ("spin_rate", "voltage", "current", "drive_torque", "electrical_power")
ROUGH = {"law": "regularized", "coefficient": 0.6, "slip_speed": 0.05}


@pytest.mark.parametrize("method", ["heun", "dopri5", "radau5", "auto"])
def test_every_method_takes_motors(method):
    drive = MOTOR | {"rate": 15.0, "proportional": 0.8, "integral": 4.0, "inductance": 4e-3, "voltage_limit": 5.0}
    expected = spin_of(drive, "time.step=2e-4", "time.output_interval=0.01")[1]
    rate = spin_of(drive, "time.step=2e-4", "time.output_interval=0.01", f"solver.method={method}")[1]
    assert np.abs(rate - expected).max() < (1e-3 if method == "heun" else 1e-7)  # rad/s, of 15


def test_a_current_too_fast_for_the_step_is_told_and_implicit_steps_take_it():
    drive = MOTOR | {"voltage": 6.0, "inductance": 1e-4}  # 12000 1/s
    data = machine("mecanum", drives=[drive])
    stopped = omnisim.simulate(scene(data, "time.end=0.05"))
    assert stopped.attributes["status"].startswith("the current of a motor settles at 1.2e+04 1/s")
    assert "time.step < 0.00012 s" in stopped.attributes["status"]
    for law in ({"law": "none"}, {"law": "coulomb", "coefficient": 0.5}):
        warned = scene(data | {"friction": law})
        assert "settle at up to 1.2e+04 1/s, too fast" in explanation(warned.config, pack(warned.config))
    for method in ("auto", "radau5"):
        run_by = run(data, "time.end=0.05", f"solver.method={method}")
        slow = run(machine("mecanum", drives=[MOTOR | {"voltage": 6.0}]), "time.end=0.05")
        apart = run_by["wheels/w0/spin_rate"][1:] - slow["wheels/w0/spin_rate"][1:]
        assert 1e-4 < np.abs(apart).max() < 0.5  # rad/s: late by L / R


def test_a_motor_from_its_data_sheet_has_the_speed_and_the_stall_of_it():
    """No-load speed and current reached; torque and current over speed, carried on to standstill, are those stalled."""
    drive = {"kind": "dc_motor", "gear_ratio": 20.0, "voltage": 24.0, "friction_rate": 1e-3, "rotor_inertia": 1e-4}
    drive |= SHEET
    trajectory, rate, _, current = spin_of(drive, "time.end=4", "time.step=1e-3")
    assert rate[-1] == pytest.approx(950.0 / 20.0, rel=1e-6)
    assert current[-1] == pytest.approx(0.4, rel=1e-4)
    line = (rate > 1.0) & (rate < 40.0)
    stall = [np.polyval(np.polyfit(rate[line], y[line], 1), 0.0)
             for y in (trajectory["wheels/w0/drive_torque"], current)]  # fmt: skip
    assert stall == pytest.approx([20.0 * 0.49, 20.0], rel=1e-6)
    law = drive_law(scene(machine("mecanum", drives=[drive])).config.wheels[0].drive)
    assert law.motor.resistance == 1.2 and law.motor.constant == pytest.approx(20.0 * 24.0 * (1 - 0.02) / 950.0)


def test_a_loop_commands_motors_and_what_it_did_repeats():
    drive = MOTOR | {"proportional": 0.8, "integral": 4.0, "voltage_limit": 12.0}
    data = machine("mecanum", drives=[drive | {"sample_time": 2e-3}] * 4,
                   friction={"law": "coulomb", "coefficient": 0.5},
                   command={"times": [0.0], "twist": [[0.0, 0.0, 0.0]]})  # fmt: skip
    loop = omnisim.Loop(scene(data, "time.end=0.2", "time.step=1e-3"))
    while loop.advance(0.01):
        loop.command(0.2, 0.1 * np.sin(30.0 * loop.time), 0.3)
    told = loop.trajectory()
    again = omnisim.simulate(omnisim.load_text(told.attributes["scene"]))
    assert told.complete and again.complete and "[command]" not in told.attributes["scene"]
    for path in ("body/position", "body/velocity", "wheels/w1/voltage", "wheels/w2/target_rate", "energy/electrical"):
        assert np.abs(told[path] - again[path]).max() < 1e-9, path
    assert np.abs(told["wheels/w0/target_rate"] - told["wheels/w0/spin_rate"])[-1] < 0.5  # it follows


def test_a_trajectory_from_before_motors_told_their_currents_still_opens(tmp_path):
    new = {"voltage", "current", "electrical_power", "heat", "target_rate", "electrical", "motor_loss", "motor_work",
           "magnetic"}  # fmt: skip
    told = spin_of(MOTOR | {"voltage": 6.0}, "time.step=1e-3")[0]
    old = {path: values for path, values in told.data.items() if path.rpartition("/")[2] not in new}
    assert len(old) <= len(told.data) - 9  # four of the wheel, five energies; extremes of some of them
    omnisim.Trajectory(told.attributes, old).save(tmp_path / "old.h5")
    opened = omnisim.open_trajectory(tmp_path / "old.h5")
    assert "energy/electrical" not in opened and "wheels/w0/drive_torque" in opened


def test_steps_that_are_picked_suit_the_samples():
    """The search for an error and the ladder of a bench pass over steps that do not go into the sample time."""
    drive = MOTOR | {"rate": 5.0, "proportional": 0.8, "sample_time": 3e-3}
    searched = scene(machine("mecanum", drives=[drive]), "solver.error=1e-6", "time.output_interval=0.01")
    steps = [candidate.config.time.step for candidate, _ in zip(candidates(searched), range(6), strict=False)]
    assert steps == pytest.approx([1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5])
    own = scene(machine("mecanum", drives=[drive]), "time.step=1e-3", "time.output_interval=0.01")
    assert ladder(own) == pytest.approx([1e-3, 5e-4])
    with pytest.raises(omnisim.SceneError, match="and the sample time"):
        ladder(own, [2e-3])


def test_the_platform_of_24_volts_drives_round_its_square():
    run = omnisim.simulate(omnisim.load("platform24v"))
    assert run.complete and run.attributes["wall_time"] < 2.0
    off = run["body/position"][[125, 250, 375, 520], :2] - [[0.5, 0.0], [0.5, 0.5], [0.0, 0.5], [0.0, 0.0]]
    assert np.abs(off).max() < 0.01  # m; measured 8.3 mm, after it went sideways
    for wheel in run.wheels:
        voltage, current = (np.abs(run[f"wheels/{wheel}/{name}"]) for name in ("voltage", "current"))
        assert voltage.max() < 24.0 and current.max() <= 6.0
    assert np.abs(run["energy/balance"]).max() < 1e-5 * run["energy/electrical"][-1]
