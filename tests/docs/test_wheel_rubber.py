"""What rubber and gaps do to a machine, on the page on the choice of wheels."""

import math
import re

import pytest

from docs.wheel_rubber import BEGIN, CUT, END, HARD, MASS, PAGE, SOFT, STEP, TOLD, candidates, driven, drop, table

RADIUS, RING, COUNT = 0.052, 0.0435, 11  # m, m, of the wheel
COSINE = math.sqrt(0.5)  # of the angle of its rollers
HOPS = "hard, gaps"
STAYS, FREELY = 5e-4, 0.05  # of a number of a machine that stays on the floor, of one that hops


def numbers(text):
    """By motion and wheel."""
    found, motion = {}, ""
    for row in text.splitlines()[2:]:
        first, name, *cells = (cell.strip() for cell in row.split("|")[1:-1])
        motion = first or motion
        found[motion, name] = [float(number) for cell in cells for number in re.findall(r"^[\d.]+", cell)]
    return found


@pytest.mark.short
def test_gaps_let_the_wheel_down_further_than_hard_rubber_sinks_and_less_than_soft():
    """Between two rollers the wheel stands on their rims: 0.2956 mm lower than on the middle of one."""
    wheels = {wheel.name: wheel for wheel in candidates()}
    cut, half = math.radians(CUT), math.pi / COUNT
    lowest = RADIUS - RING / math.cos(cut)
    along = RING * math.tan(cut) / COSINE + lowest * COSINE * math.sin(cut)
    across = lowest * math.sqrt(1.0 - (COSINE * math.sin(cut)) ** 2)
    sine = COSINE * math.sin(half)
    expected = RADIUS - RING * math.cos(half) - along * sine - across * math.sqrt(1.0 - sine**2)
    assert drop(wheels[HOPS]) == pytest.approx(expected, rel=1e-9)
    assert drop(wheels["soft, gaps"]) == drop(wheels[HOPS]) and drop(wheels["hard, no gap"]) < 1e-12
    assert MASS * 9.81 / 4.0 / HARD < expected < MASS * 9.81 / 4.0 / SOFT


@pytest.mark.long
def test_the_page_has_what_the_runs_do():
    wheels = candidates()
    made = numbers(table(wheels, driven(wheels, TOLD)))
    shown = numbers(PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0])
    assert list(made) == list(shown) and len(shown) == len(TOLD) * len(wheels)
    for (motion, name), row in shown.items():
        digits = {"rel": FREELY, "abs": 0.0} if name == HOPS else {"rel": 1e-2, "abs": 0.011}
        assert made[motion, name] == pytest.approx(row, **digits), name


@pytest.mark.long
def test_half_the_step_tells_the_same():
    """Peak loads differ most, by 1.4e-4; of the machine that hops by 2.0e-2."""
    coarse, fine = (driven(candidates(step), ("forward",)) for step in (STEP, 0.5 * STEP))
    for wheel, one, other in zip(candidates(), coarse, fine, strict=True):
        bound = FREELY if wheel.name == HOPS else STAYS
        for name in ("ripple", "energy", "load"):
            pair = getattr(one["forward"][0], name), getattr(other["forward"][0], name)
            assert pair[0] == pytest.approx(pair[1], rel=bound, abs=1e-6), (wheel.name, name)
