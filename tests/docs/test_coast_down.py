"""The arithmetic of the page on rolling: a machine with the losses that it finds coasts as published."""

import re

import pytest

from docs.coast_down import (
    ACROSS,
    AHEAD,
    ALONG,
    ASIDE,
    BEGIN,
    BEGIN_SPEED,
    COULOMB,
    END,
    PAGE,
    STRAFING,
    Motor,
    behind,
    deceleration,
    losses,
    needed,
    speed_table,
    strafing,
)


def told(begin):
    return PAGE.read_text(encoding="utf-8").partition(begin)[2].partition(END)[0]


def test_the_rolling_resistance_of_the_page_slows_a_machine_as_published():
    """Without the rollers' own inertia and with the mean over a roller: aside to 1.2 %."""
    lost = losses(1.0)
    assert lost.bearing == 0.0
    assert deceleration(lost, ALONG) == pytest.approx(AHEAD, rel=1e-3)
    assert deceleration(lost, ACROSS) == pytest.approx(ASIDE, rel=2e-2)


def test_bearings_of_12_9_n_mm_without_rolling_resistance_slow_a_machine_as_published_too():
    """Axles do the rest: bearings alone take nothing ahead. 12, 14 and 16 N mm: 1.782, 1.870 and 1.961 m/s^2 aside."""
    assert "bearings of 12.9 N mm" in PAGE.read_text(encoding="utf-8")
    lost = losses(0.0)._replace(bearing=12.9e-3)
    assert deceleration(lost, ALONG) == pytest.approx(AHEAD, rel=1e-3)
    assert deceleration(lost, ACROSS) == pytest.approx(ASIDE, rel=2e-3)
    assert deceleration(lost._replace(axle=0.0), ALONG) == pytest.approx(0.0, abs=1e-6)


def test_the_page_has_the_numbers_of_the_script():
    table = told(BEGIN)
    rows = [[float(cell) for cell in row.split("|")[1:4]] for row in table.splitlines() if re.match(r"\| [0-9]", row)]
    for row, part in zip(rows, (1.0, 0.5, 0.0), strict=True):
        lost = losses(part)
        assert row == [float(f"{value:.3g}") for value in (1e3 * lost.resistance, 1e3 * lost.bearing, lost.axle)]


def test_the_page_tells_what_each_thing_alone_would_have_to_be():
    need = needed()
    for key in ("resistance", "bearing", "by load", "by thrust"):
        assert f"{1e3 * need[key]:.2g} " in told(BEGIN_SPEED), key
    for key, unit in (("stall", "N m"), ("supply", "ohm"), ("voltage", "V")):
        assert f"| {need[key]:.2g} {unit} |" in told(BEGIN_SPEED), key


@pytest.mark.parametrize("motor", [Motor(needed()["stall"]), behind(needed()["supply"], Motor())], ids=["weak", "sags"])
def test_a_motor_as_weak_as_the_page_says_is_as_slow_aside_as_published(motor):
    """0.724: coasting aside errs by 1.2 % of its own."""
    assert strafing(losses(1.0), motor, COULOMB) == pytest.approx(STRAFING, rel=1e-2)


@pytest.mark.long
def test_the_page_has_what_machines_at_full_power_do():
    made, page = ([row.split("|")[1:] for row in text.splitlines()] for text in (speed_table(), told(BEGIN_SPEED)))
    for row, shown in zip(made[2:], page[2:], strict=True):
        assert row[:3] == shown[:3]
        assert [float(cell) for cell in row[3:6]] == pytest.approx([float(cell) for cell in shown[3:6]], rel=5e-3)
