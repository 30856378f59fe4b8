"""What is said of trajectories: how well energy balances, how far two lie apart."""

import numpy as np
import pytest
from synthetic import synthetic_attributes, synthetic_data, synthetic_trajectory

from omnisim.results.comparison import compare, divergence, energy_error
from omnisim.results.trajectory import Trajectory

ROLLER = "wheels/wheel/contact_roller"


def trajectory(**changes):
    """A synthetic trajectory with some datasets replaced; __ stands for /."""
    data = synthetic_data()
    changed = {path.replace("__", "/"): np.asarray(values) for path, values in changes.items()}
    return Trajectory(synthetic_attributes(), data | changed)


def found(comparison, path):
    return next(row for row in comparison.differences if row.path == path)


def test_a_trajectory_does_not_differ_from_itself():
    comparison = compare(synthetic_trajectory(), synthetic_trajectory())
    assert (comparison.rows, comparison.apart, comparison.events) == (11, 0, (3, 3))
    assert all(row.difference == 0.0 for row in (*comparison.differences, *comparison.centre_height))


def test_the_largest_difference_of_every_dataset_is_found_with_its_unit():
    velocity = synthetic_data()["body/velocity"]
    moved = velocity.copy()
    moved[3, 1] += 0.5
    moved[7, 2] -= 0.75
    row = found(compare(trajectory(), trajectory(body__velocity=moved)), "body/velocity")
    assert row.difference == pytest.approx(0.75, rel=1e-15)
    assert (row.units, row.largest) == ("m/s", np.abs(velocity).max())


def test_divergence_is_the_largest_difference_so_far():
    position, yaw = synthetic_data()["body/position"].copy(), synthetic_data()["body/yaw"].copy()
    position[3, 1] += 0.25
    yaw[9] -= 0.5
    parts = divergence(trajectory(), trajectory(body__position=position, body__yaw=yaw))
    time = synthetic_trajectory().time
    assert [part.until for part in parts] == [time[row] for row in (1, 3, 6, 8, 10)]  # of 11 rows
    assert [part.position for part in parts] == pytest.approx([0.0, 0.25, 0.25, 0.25, 0.25])
    assert [part.angle for part in parts] == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.5])
    assert all(part.velocity == part.normal_force == 0.0 for part in parts)


def test_the_centre_height_is_z_of_roller_0_alone():
    path = "wheels/wheel/rollers/center_position"
    moved = synthetic_data()[path].copy()
    moved[4, 0, 2] += 0.25
    moved[5, 1, 2] += 9.0  # another roller
    moved[6, 0, 0] += 9.0  # another direction
    acceleration, velocity, position = compare(
        trajectory(), trajectory(**{path.replace("/", "__"): moved})
    ).centre_height
    assert position.difference == pytest.approx(0.25, rel=1e-14)
    assert acceleration.difference == velocity.difference == 0.0


def test_rows_between_the_exchanges_of_the_two_are_left_out_and_counted():
    rollers, point = synthetic_data()[ROLLER].copy(), synthetic_data()["wheels/wheel/contact_point"].copy()
    rollers[5] += 1
    point[5] += 100.0
    b = trajectory(wheels__wheel__contact_roller=rollers, wheels__wheel__contact_point=point)
    comparison = compare(trajectory(), b)
    assert comparison.apart == 1
    assert found(comparison, "wheels/wheel/contact_point").difference == 0.0


def test_a_shorter_run_is_compared_up_to_its_end():
    a, b = synthetic_trajectory(rows=11, events=3), synthetic_trajectory(rows=6, events=5)
    comparison = compare(a, b)
    assert (comparison.rows, comparison.events) == (6, (3, 5))
    assert found(comparison, "events/time").difference == 0.0


def test_runs_without_rows_and_events_compare():
    comparison = compare(synthetic_trajectory(rows=0, events=0), synthetic_trajectory())
    assert (comparison.rows, comparison.events) == (0, (0, 3))


def test_words_and_rollers_are_counted():
    kinds = synthetic_data()["events/kind"].copy()
    kinds[1] = "stop"
    row = found(compare(trajectory(), trajectory(events__kind=kinds)), "events/kind")
    assert (row.units, row.largest, row.difference) == ("entries", 3.0, 1.0)


def test_energy_is_measured_by_what_was_there_at_the_start():
    error = energy_error(trajectory(energy__kinetic=np.full(11, 4.0), energy__balance=np.linspace(0.0, -2.0, 11)))
    assert (error.absolute, error.relative, error.scale_name) == (2.0, 0.5, "the initial kinetic energy")


def test_energy_from_rest_is_measured_by_what_was_turned_over():
    kinetic = np.linspace(0.0, 1.0, 11)
    works = {f"energy__{name}": np.linspace(0.0, w, 11) for name, w in
             {"friction_loss": 1.0, "drive_work": 3.0, "wrench_work": -4.0, "balance": 0.8}.items()}  # fmt: skip
    error = energy_error(trajectory(energy__kinetic=kinetic, **works))
    assert (error.absolute, error.scale, error.relative) == (0.8, 8.0, 0.1)
    barely = energy_error(trajectory(energy__kinetic=kinetic + 1e-9, **works))
    assert (barely.scale, barely.scale_name) == (8.0, "the energy turned over")


def test_nothing_that_moves_has_no_relative_error():
    still = {f"energy__{name}": np.zeros(11) for name in ("kinetic", "friction_loss", "drive_work",
                                                         "wrench_work", "balance")}  # fmt: skip
    assert energy_error(trajectory(**still)).relative == 0.0
    assert energy_error(synthetic_trajectory(rows=0)).absolute == 0.0
