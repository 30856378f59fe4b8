"""Rubber that creeps (law "brush"): slip by force in closed form, its limits, energy, order, start from rest."""

import numpy as np
import pytest
from helpers.stages import either
from machines import locked, machine, on_slope, run, scene, tables
from scenes import final_reference, final_state, of_wheels, reference_scene

import omnisim
from omnisim.dynamics.packing import pack
from omnisim.march.stiffness import relaxation_rate

MU, C, SLOW = 0.5, 12.0, 0.01
BRUSH = {"law": "brush", "coefficient": MU, "creep_stiffness": C, "slip_speed": SLOW}
RADIUS, G = 0.0625, 9.81
TIME = {"end": 1.0, "step": 1e-3, "output_interval": 0.05}


def creep_ratio(force, load, rolling):
    """Slip by rolling speed under a force of friction, N: F = mu N (1 - (1 - theta)^3), turned round."""
    theta = 1.0 - np.cbrt(1.0 - force / (MU * load))
    return 3.0 * MU * theta / C * np.sqrt(1.0 + (SLOW / rolling) ** 2)


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
@pytest.mark.parametrize("part", [0.02, 0.5, 0.9, -0.5])
def test_wheels_that_pull_turn_faster_than_the_floor_by_the_creep_of_their_force(part, tracking):
    """Four wheels roll ahead at a steady rate and pull a load; their torques are its force times R."""
    data = machine("omni", friction=BRUSH, scene={"upright": "servo"}, time=TIME)
    data["solver"] = {"tracking": tracking, "method": "auto"}
    mass = pack(scene(data).config).machine.mass
    load, spin = mass * G / 4, 20.0
    force = part * MU * load
    sigma = creep_ratio(abs(force), load, spin * RADIUS) * np.sign(force)
    for wheel in data["wheels"]:
        wheel |= {"spin_rate": spin, "drive": {"kind": "torque", "torque": force * RADIUS}}
    data["wrench"] = {"times": [0.0], "force": [[-4.0 * force, 0.0, 0.0]]}
    data["initial"] = {"velocity": [spin * RADIUS * (1.0 - sigma), 0.0]}
    steady = run(data)
    assert (steady["events/kind"] == "exchange").sum() > 50
    assert np.abs(steady["body/velocity"][:, 0] - spin * RADIUS * (1.0 - sigma)).max() < 1e-12  # of 1.25 m/s
    assert np.abs(of_wheels(steady, "spin_rate") - spin).max() < 1e-11  # measured: 4e-13
    assert abs(sigma) > 5e-4 and np.abs(of_wheels(steady, "friction_force")[..., 0] - force).max() < 1e-10


def test_locked_wheels_on_a_slope_creep_by_the_slip_speed():
    """Their rollers stand across the slope and do not turn: V = slip_speed, 1 - (1 - theta)^3 = tan S / mu."""
    rho = 0.6
    data = locked(machine("omni", friction=BRUSH, scene={"upright": "servo"}, time=TIME), rotor=1e9)
    data["solver"] = {"method": "radau5"}
    creeping = run(on_slope(data, np.arctan(rho * MU)))
    expected = 3.0 * MU * SLOW / C * (1.0 - np.cbrt(1.0 - rho))
    assert abs(-creeping["body/velocity"][-1, 0] / expected - 1.0) < 1e-7  # 0.3 mm/s


def test_stiffer_rubber_tends_to_coulomb_friction_as_one_by_its_stiffness():
    """The reference rolls at some 0.5 m/s and slips into rest 26 times."""
    expected = final_reference("coulomb_wheel")
    errors = []
    for stiffness in (300.0, 3000.0, 30000.0):
        law = f"friction={{law='brush', coefficient=0.5, creep_stiffness={stiffness}, slip_speed=1e-4}}"
        close = omnisim.simulate(reference_scene("coulomb_wheel", law, "solver.method=radau5", "time.step=1e-3"))
        assert close.complete, close.attributes["status"]
        errors.append(np.abs(final_state(close) - expected).max())
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all((ratios > 8.0) & (ratios < 12.0)), (errors, ratios)
    assert errors[-1] < 1e-4


@pytest.mark.parametrize("formulation", either(["reduced", "multibody"], ["reduced"]))
def test_the_works_account_for_all_energy_of_a_machine_that_creeps_and_slides(formulation):
    data = tables(reference_scene("mecanum", "time.step=5e-6", "time.end=0.2", "time.output_interval=0.01"))
    data |= {"friction": BRUSH | {"slip_speed": 0.05, "creep_stiffness": 4.0}, "solver": {"formulation": formulation}}
    data["wrench"] = {"times": [0.0, 0.1, 0.1], "force": [[30.0, 90.0, 0.0], [0.0, 99.0, 0.0], [0.0, 0.0, 0.0]]}
    motion = run(data)
    size = np.hypot(*of_wheels(motion, "friction_force").T).T
    slides = size > (1.0 - 1e-12) * MU * of_wheels(motion, "normal_force")
    assert slides.any() and not slides.all()
    assert np.all(np.diff(motion["energy/friction_loss"]) > 0.0)
    turned_over = motion["energy/friction_loss"][-1]
    assert turned_over > 0.1 and np.abs(motion["energy/balance"]).max() < 1e-8 * turned_over


CREEPING = ("friction={law='brush', coefficient=0.3, creep_stiffness=5.0, slip_speed=0.05}", "time.end=1.0",
            "time.output_interval=0.02")  # fmt: skip


@pytest.mark.parametrize(("method", "order"), [("heun", 2), ("rk4", 4)])
@pytest.mark.parametrize("name", ["testbench_psi0", "testbench_psi30"])
def test_methods_keep_an_order_of_up_to_four_through_exchanges_and_where_all_slides(name, method, order):
    """Where the contact begins to slide as a whole the law has two continuous derivatives, and no event."""
    steps = {"heun": (4e-4, 2e-4, 1e-4), "rk4": (8e-4, 4e-4, 2e-4)}[method]
    finest = omnisim.simulate(reference_scene(name, *CREEPING, "solver.method=dopri5", f"time.step={steps[-1] / 16}"))
    size = np.hypot(*finest["wheels/wheel/friction_force"].T) / finest["wheels/wheel/normal_force"]
    assert np.abs(np.diff(size > 0.3 * (1.0 - 1e-12))).sum() >= 1 and "exchange" in finest["events/kind"]
    errors = []
    for step in steps:
        own = omnisim.simulate(reference_scene(name, *CREEPING, f"solver.method={method}", f"time.step={step}"))
        errors.append(np.abs(final_state(own) - final_state(finest)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders.min() >= order - 0.2, (errors, orders)


@pytest.mark.parametrize("method", ["auto", "radau5"])
def test_a_machine_starts_from_rest_without_a_jolt(method):
    """From standstill to 0.5 m/s ahead and aside: what the speed has at a step it has at a quarter of it."""
    data = tables("youbot") | {"friction": BRUSH | {"slip_speed": 1e-3}}
    data["command"] = {"times": [0.0, 0.5], "twist": [[0.0, 0.0, 0.0], [0.4, 0.3, 0.2]]}
    data["time"] = {"end": 0.6, "step": 1e-3, "output_interval": 0.01}
    coarse, fine = run(data, f"solver.method={method}"), run(data, "solver.method=radau5", "time.step=2.5e-4")
    assert np.abs(coarse["body/velocity"] - fine["body/velocity"]).max() < 1e-6
    assert np.abs(coarse["energy/balance"]).max() < 1e-6 * fine["energy/drive_work"][-1]
    speed = np.hypot(*fine["body/velocity"][:, :2].T)
    assert np.all(np.diff(speed[:50]) > 0.0) and speed[0] == 0.0


def test_the_rate_at_which_slip_relaxes_is_told_for_standstill():
    """c N / slip_speed times the inverse mass; "auto" is implicit there, and explicit as long as the machine rolls."""
    slow = scene(tables(reference_scene("kiwi")) | {"friction": BRUSH})
    fast = scene(tables(reference_scene("kiwi")) | {"friction": BRUSH | {"slip_speed": SLOW / 10.0}})
    rates = [relaxation_rate(entry.config, pack(entry.config)) for entry in (slow, fast)]
    assert rates[1] == pytest.approx(10.0 * rates[0], rel=1e-12)
    smooth = scene(tables(reference_scene("kiwi")) | {"friction": BRUSH | {"law": "regularized"}})
    assert rates[0] == pytest.approx(C / MU * relaxation_rate(smooth.config, pack(smooth.config)), rel=1e-12)


@pytest.mark.short
@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (("friction={law='brush', coefficient=0.5, slip_speed=0.01}",), "friction.creep_stiffness: missing"),
        (("friction={law='brush', coefficient=0.5, creep_stiffness=9.0}",), "friction.slip_speed: missing"),
        (("friction={law='brush', coefficient=0.5, slip_speed=0.01, creep_stiffness=1.2}",), "at least 3 coefficient"),
        (("friction={law='brush', coefficient=0.5, slip_speed=0.01, creep_stifness=9.0}",), "creep_stiffness"),
        (("friction={law='brush', coefficient=0.5, slip_speed=0.01, creep_stiffness=9.0, contact_torque='contensou', "
          "patch_radius=0.002}",), "only 'regularized' has one"),
    ],
)  # fmt: skip
def test_what_is_no_brush_says_so(overrides, words):
    with pytest.raises(omnisim.SceneError) as error:
        reference_scene("testbench_psi0", *overrides)
    assert words in str(error.value) and "\n" not in str(error.value)
