"""What rollers with losses cost, on the page on the choice of wheels."""

import re

import pytest

import omnisim
from docs.wheel_losses import BEGIN, END, MASS, PAGE, RESISTANCE, WHEEL, losses, table
from omnisim.studies.wheel_cycle import CURES, SPEED, Platform, compare_wheels, driven


def told():
    return PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]


def numbers(text):
    return [
        [float(cell) for cell in row.split("|")[2:6]] for row in text.splitlines() if re.search(r"\d\.\d\d \|", row)
    ]


@pytest.mark.short
def test_ahead_rolling_resistance_costs_its_arm_by_the_radius_and_bearings_cost_nothing():
    """f m g / R = 1.89 J/m: rollers do not turn in their bearings."""
    rolls = RESISTANCE * MASS * 9.81 / omnisim.load(WHEEL).config.wheel_types[WHEEL].radius
    assert [row[0] for row in numbers(told())] == pytest.approx([0.0, 0.0, rolls, rolls], abs=5e-3)


@pytest.mark.long
def test_the_page_has_what_the_runs_lose():
    wheels = losses()
    made = table([wheel.name for wheel in wheels], compare_wheels(wheels, MASS))
    assert numbers(made) == [pytest.approx(row, rel=1e-2, abs=1e-2) for row in numbers(told())]


@pytest.mark.long
def test_half_the_step_of_a_row_with_bearings_tells_the_same():
    """Sideways: losses differ by 1.3e-8 of them, energy by 1.1e-7, ripple by 1.1e-8, the peak load by 8.3e-5."""
    task = Platform(losses()[1], MASS, SPEED), "sideways"
    method, step = CURES[0]
    (coarse,), (fine,) = driven([task], (method, step)), driven([task], (method, 0.5 * step))
    for name, bound in (("drag", 7e-7), ("energy", 5e-7), ("ripple", 5e-7), ("load", 9e-5)):
        assert getattr(coarse, name) == pytest.approx(getattr(fine, name), rel=bound), name
