"""What the benchmarks of accuracy and of precision claim, and that their scenes have what they claim it of."""

import numpy as np
import pytest

from bench import accuracy, alike, precision, precision_scenes


def test_claims_of_accuracy_are_orders_and_the_error_at_the_own_step():
    rows = [
        {"method": "rk4", "tracking": tracking, "step_s": step, "error": error}
        for tracking, step, error in (("explicit", 1e-3, 1e-6), ("explicit", 1e-4, 2e-9), ("implicit", 1e-4, 1e-12))
    ]
    data = {"own_step_s": 1e-4, "orders": {"rk4": 3.6, "radau5": 6.1}, "rows": rows, "alike": {}}
    order, error = accuracy.claims({"six_rollers": data})
    assert (order.value, order.met, order.alarming) == (3.6, False, False)
    assert (error.value, error.met, error.alarming) == (2e-9, False, True)
    rows[1]["error"] = None  # the run stopped
    assert accuracy.claims({"six_rollers": data})[1].alarming


def test_an_order_over_many_machines_tells_its_uncertainty():
    rows = [{"method": method, "tracking": "explicit", "step_s": 1e-3, "error": 1e-9} for method in ("rk4", "dopri5")]
    data = {
        "own_step_s": 1e-3,
        "orders": {"bs5": 4.65},
        "rows": rows,
        "alike": {
            "bs5": {
                "order": 4.65,
                "uncertainty": 0.08,
                "errors": {"0.001": 1e-9},
                "by_power": 0.93,
                "by_power_uncertainty": 0.02,
            }
        },
    }
    order, by_power, *_ = accuracy.claims({"near_limit": data})
    assert (order.met, order.alarming) == (False, False)
    assert "a standard error of 0.08" in order.reason and "at most 0.93 ± 0.02 of" in order.reason
    assert by_power.value == 0.93 and by_power.met


def test_claims_of_precision_are_the_fastest_march_that_is_accurate_enough():
    def row(error, seconds, step):
        work = {"steps": 160, "rhs_evaluations": 1500, "events": 50}
        return {"method": "dopri5", "error": error, "wall_s_per_simulated_s": seconds, "step_s": step, **work}

    (speed,) = precision.claims({"coulomb_wheel": {"rows": [row(2e-6, 1e-5, 0.02), row(9e-7, 5e-5, 0.0125)]}})
    assert speed.value == pytest.approx(2e4) and speed.met and "at 0.0125 s" in speed.reason
    (none,) = precision.claims({"coulomb_wheel": {"rows": [row(None, None, 0.02)]}})
    assert none.value == 0.0 and none.alarming


@pytest.mark.parametrize("name", precision_scenes.ENTRIES)
def test_every_scene_of_precision_has_its_own_step_on_the_ladder_of_a_bounded_method(name):
    entry = precision_scenes.ENTRIES[name]
    step, settings = entry.scene().config.time.step, entry.settings(precision_scenes.METHODS)
    assert all(precision_scenes.Setting(method, "explicit", step) in settings for method in entry.bounds)
    assert len(settings) == len(set(settings))


def test_errors_that_follow_a_power_of_the_step_tell_that_power_and_no_uncertainty():
    """Of machines whose errors differ by a factor; if the shortest step errs half as much, longer ones are twice the
    power through it."""
    factors, steps = np.array([1.0, 3.0, 0.2]), np.array([4e-3, 2e-3, 1e-3, 5e-4])
    for better in (1.0, 0.5):
        errors = factors[:, None] * steps**4 * np.array([1.0, 1.0, 1.0, better])
        found = alike.order_of("rk4", steps.tolist(), errors, np.full(3, 1e-16))
        assert found.order == pytest.approx(4.0) and found.by_power == pytest.approx(1.0 / better)
        assert found.uncertainty < 1e-12 and found.by_power_uncertainty < 1e-12
        assert found.errors["0.001"] == pytest.approx(0.6 ** (1 / 3) * 1e-12)
    assert alike.standard_error([1.0, 2.0, 3.0]) == pytest.approx(3.0**-0.5)
