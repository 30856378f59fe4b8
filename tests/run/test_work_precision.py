"""Errors and orders of the ladder are those of the methods; the front is what nobody beats."""

import math

import pytest

import omnisim
from omnisim.run import work_precision as precision
from omnisim.run.work_precision import Interrupted, Row, Setting, measure

TINY = ("time.end=0.2",)
STEPS = (5e-4, 2e-4)


def settings(*methods, steps=STEPS, trackings=("explicit",)):
    return [Setting(method, tracking, step) for method in methods for tracking in trackings for step in steps]


def row(error, march, step=1e-3, method="rk4"):
    return Row(method, "explicit", step, error, None, march, march, 1, 4, 0, False, "complete")


@pytest.fixture(scope="module")
def measured():
    chosen = settings("heun", "rk4", trackings=("explicit", "implicit"))
    return measure(omnisim.load("six_rollers", TINY), chosen, 2)


def test_each_method_shows_its_own_order_with_both_trackings(measured):
    orders = precision.finest_orders(measured)
    for tracking in ("explicit", "implicit"):
        assert orders["heun", tracking] == pytest.approx(2.0, abs=0.1)  # measured: 1.98, 2.00
        assert orders["rk4", tracking] == pytest.approx(4.0, abs=0.2)  # measured: 4.13, 4.13


def test_errors_shrink_with_the_step_and_the_reference_resolves_them(measured):
    assert measured.reference.distance < 1e-12  # measured: 3.6e-13
    for coarse, fine in zip(measured.rows[::2], measured.rows[1::2], strict=True):
        assert measured.reference.distance < fine.error < coarse.error / 3


def test_every_row_has_its_work_and_its_times(measured):
    assert measured.repeats == 2
    for found in measured.rows:
        assert found.steps == round(0.2 / found.step) and found.events == measured.rows[0].events > 0
        assert found.evaluations >= found.steps * {"heun": 2, "rk4": 4}[found.method]
        assert 0.0 < 0.2 * found.march < found.whole


def test_the_ladder_is_what_suits_the_output():
    assert precision.ladder(omnisim.load("six_rollers")) == [1e-3, 5e-4, 2e-4, 1e-4, 5e-5]
    coarse = omnisim.load("six_rollers", ["time.step=5e-3"])  # 2 steps for each row
    assert precision.ladder(coarse) == [1e-2, 5e-3, 2.5e-3]
    assert precision.ladder(coarse, (1e-4, 1e-3, 1e-4)) == [1e-3, 1e-4]
    with pytest.raises(omnisim.SceneError, match="must divide the output interval"):
        precision.ladder(coarse, (3e-3,))


def test_the_front_is_what_nobody_beats():
    points = [(1e-3, 1.0), (1e-6, 2.0), (1e-5, 3.0), (1e-6, 2.5), (1e-9, 4.0), (1e-3, 1.0)]
    assert precision.pareto(points) == [True, True, False, False, True, True]
    assert precision.pareto([]) == []


def test_errors_below_the_reference_are_alike_and_tell_no_order():
    rows = [row(1e-6, 1.0, 1e-3), row(1e-13, 2.0, 5e-4), row(1e-14, 3.0, 1e-4), row(None, None, 1e-5)]
    judged = precision.judged(rows, trusted=1e-12)
    assert [found.front for found in judged] == [True, True, False, False]
    assert [found.order for found in judged] == [None] * 4


def test_the_order_is_that_between_neighbours_of_the_ladder():
    errors = {4e-3: 1e-2, 2e-3: 1e-2 / 4, 1e-3: 1e-2 / 64}
    rows = [row(error, 1.0, step) for step, error in errors.items()] + [row(1e-9, 1.0, 2e-3, "dopri5")]
    assert [found.order for found in precision.judged(rows, 0.0)] == [
        None,
        pytest.approx(2.0),
        pytest.approx(4.0),
        None,
    ]


def test_a_step_that_is_hardly_longer_tells_no_order():
    rows = [row(1.6e-3, 1.0, 2e-3), row(1e-4, 1.0, 1.1e-3), row(1e-4, 1.0, 1e-3)]
    assert precision.judged(rows, 0.0)[-1].order == pytest.approx(4.0)  # 0 from that at 1.1e-3 s


def test_the_fastest_is_accurate_as_far_as_the_reference_can_tell(measured):
    assert precision.fastest(measured, 1e-7).method == "rk4"
    assert precision.fastest(measured, math.inf).march == min(found.march for found in measured.rows)
    assert precision.fastest(measured, 1e-15) is None


def test_each_scene_is_made_once_so_that_whole_calls_are_timed_as_a_user_repeats_them(monkeypatch):
    made, varied = [], precision.varied
    monkeypatch.setattr(precision, "varied", lambda scene, setting: made.append(setting) or varied(scene, setting))
    chosen = settings("rk4")
    found = measure(omnisim.load("six_rollers", TINY), chosen, 1)
    assert made == [*chosen, *found.reference[1:3]]


def test_an_interrupted_measurement_keeps_its_complete_rounds():
    class Impatient:
        calls = 0

        def __call__(self, fraction):
            assert 0.0 <= fraction < 1.0
            self.calls += fraction > 0.5
            if self.calls > 60:
                raise Interrupted

    found = measure(omnisim.load("six_rollers", TINY), settings("heun"), 100, Impatient())
    assert 0 < found.repeats < 100 and all(row.march for row in found.rows)

    def at_once(_):
        raise Interrupted

    with pytest.raises(Interrupted):
        measure(omnisim.load("six_rollers", TINY), settings("heun"), 1, at_once)
