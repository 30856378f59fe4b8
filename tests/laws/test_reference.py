"""The converged reference cases, good to 1e-10, and the order at which each method reaches them."""

import numpy as np
import pytest
from scenes import (
    REFERENCE_CASES,
    REFERENCE_MACHINES,
    final_reference,
    final_state,
    of_wheels,
    reference_data,
    simulate,
)

STEP, MACHINE_STEP = "time.step=2e-5", "time.step=1e-5"


@pytest.fixture(scope="module", params=REFERENCE_CASES)
def case(request):
    return simulate(request.param, STEP), reference_data(request.param)


@pytest.fixture(scope="module", params=REFERENCE_MACHINES)
def machine(request):
    return simulate(request.param, MACHINE_STEP), reference_data(request.param)


def worst(values, expected):
    return np.abs(values - expected).max()


def test_position_and_angles_agree_to_1e_9_at_all_times(case):
    run, reference = case
    assert worst(run["body/position"][:, :2], reference["position"]) < 1e-9  # measured 1.2e-13, 7.9e-12
    assert worst(run["body/yaw"], reference["yaw"]) < 1e-9  # 6.8e-13, 1.1e-11
    assert worst(run["wheels/wheel/spin_angle"], reference["spin_angle"]) < 1e-9  # 1.9e-12, 5.3e-11


def test_velocities_agree_to_1e_8_at_all_times(case):
    run, reference = case
    assert worst(run["body/velocity"][:, :2], reference["velocity"]) < 1e-8  # measured 2.4e-12, 3.2e-11
    assert worst(run["body/yaw_rate"], reference["yaw_rate"]) < 1e-8  # 5.5e-12, 2.6e-10
    assert worst(run["wheels/wheel/spin_rate"], reference["spin_rate"]) < 1e-8  # 8.7e-12, 2.3e-10
    # the rates of the rollers in the reference are good to 1e-8 only
    assert worst(run["wheels/wheel/rollers/axial_rate"], reference["roller_axial_rate"]) < 2e-8  # 7.5e-10, 6.9e-9


def test_exchange_times_agree_to_1e_9(case):
    run, reference = case
    exchanges = run["events/time"][run["events/kind"] == "exchange"]
    assert len(exchanges) == len(reference["exchange_times"])
    assert worst(exchanges, reference["exchange_times"]) < 1e-9  # measured 8.4e-13, 1.4e-11


def test_energy_is_balanced_to_1e_9_of_the_initial_energy(case):
    run, _ = case
    initial = run["energy/kinetic"][0]
    assert np.abs(run["energy/balance"]).max() < 1e-9 * initial  # measured 5.9e-13, 3.4e-13 of it


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
@pytest.mark.parametrize("name", REFERENCE_CASES)
def test_rk4_shows_its_order_across_exchanges(name, tracking):
    exact = final_reference(name)
    steps = (4e-4, 2e-4, 1e-4, 5e-5)
    errors = [
        worst(final_state(simulate(name, f"time.step={step}", f"solver.tracking={tracking}")), exact) for step in steps
    ]
    order = np.log2(errors[0] / errors[-1]) / 3
    assert order >= 3.8, errors  # measured 4.00 on both, either tracking


def test_a_machine_agrees_to_1e_10_in_its_pose_and_to_1e_9_in_its_spin_angles_at_all_times(machine):
    run, reference = machine
    assert worst(run["body/position"][:, :2], reference["position"]) < 1e-10  # measured 3.0e-14, 5.0e-13
    assert worst(run["body/yaw"], reference["yaw"]) < 1e-10  # 3.5e-13, 6.2e-13
    assert worst(of_wheels(run, "spin_angle"), reference["spin_angle"]) < 1e-9  # 3.0e-12, 1.9e-10


def test_velocities_of_a_machine_agree_to_1e_9_and_its_spin_rates_to_2e_9_at_all_times(machine):
    run, reference = machine
    assert worst(run["body/velocity"][:, :2], reference["velocity"]) < 1e-9  # measured 1.5e-12, 1.0e-12
    assert worst(run["body/yaw_rate"], reference["yaw_rate"]) < 1e-9  # 1.6e-12, 2.8e-12
    assert worst(of_wheels(run, "spin_rate"), reference["spin_rate"]) < 2e-9  # 2.1e-11, 2.5e-10


def test_a_machine_stands_on_its_wheels_with_the_loads_of_the_reference(machine):
    run, reference = machine
    assert worst(of_wheels(run, "normal_force")[0], reference["normal_force_start"]) < 1e-12  # N; measured 3.6e-15, 0


def test_the_rollers_of_a_machine_change_in_the_same_order_at_times_within_1e_9(machine):
    run, reference = machine
    exchanges = run["events/kind"] == "exchange"
    assert list(run["events/wheel"][exchanges]) == list(reference["exchange_wheels"])  # 10 and 36 of them
    assert worst(run["events/time"][exchanges], reference["exchange_times"]) < 1e-9  # measured 2.9e-12, 6.4e-11


def test_the_energy_of_a_machine_is_balanced(machine):
    run, _ = machine
    assert np.abs(run["energy/balance"]).max() < 1e-7 * run["energy/kinetic"][0]  # measured 1.7e-12, 1.4e-8 of it


# Steps that are stable in the first instants, when wheels slip fast; the mecanum wheels relax slip at 30000 1/s.
LADDERS = [("kiwi", 4e-4, 4), ("mecanum", 2e-5, 3)]


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
@pytest.mark.parametrize(("name", "first", "count"), LADDERS)
def test_rk4_shows_its_order_on_machines(name, first, count, tracking):
    exact, steps = final_reference(name), [first / 2**i for i in range(count)]
    errors = [
        worst(final_state(simulate(name, f"time.step={step}", f"solver.tracking={tracking}")), exact) for step in steps
    ]
    order = np.log2(errors[0] / errors[-1]) / (count - 1)
    assert order >= 3.8, errors  # measured 4.07 and 4.34, either tracking
