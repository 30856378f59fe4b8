"""The arithmetic of the page on rolling: a machine with the losses that it finds coasts as published."""

import re

import pytest

from docs.coast_down import ACROSS, AHEAD, ALONG, ASIDE, BEGIN, END, PAGE, deceleration, losses


def test_the_rolling_resistance_of_the_page_slows_a_machine_as_published():
    """Without the rollers' own inertia and with the mean over a roller: aside to 1.2 %."""
    lost = losses(1.0)
    assert lost.bearing == 0.0
    assert deceleration(lost, ALONG) == pytest.approx(AHEAD, rel=1e-3)
    assert deceleration(lost, ACROSS) == pytest.approx(ASIDE, rel=2e-2)


def test_the_page_has_the_numbers_of_the_script():
    table = PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    rows = [[float(cell) for cell in row.split("|")[1:4]] for row in table.splitlines() if re.match(r"\| [0-9]", row)]
    for row, part in zip(rows, (1.0, 0.5, 0.0), strict=True):
        lost = losses(part)
        assert row == [float(f"{value:.3g}") for value in (1e3 * lost.resistance, 1e3 * lost.bearing, lost.axle)]
