"""The table of hard cases, bench/hard_cases.py: every scene in it moves as is claimed there, or says why it stops."""

from functools import cache

import pytest

from bench import hard_cases
from bench.hard_cases import CASES

LEAST = 59  # hard scenes

LONG = (
    "coasting on two rollers", "psi = 80 deg", "pointed tips", "near the limit", "near the limit, regularized", "kerb",
    "pits", "ground of ridges", "standing on a slope", "bump under a platform", "tilted by 30 deg", "stuck for 1e5 s",
    "slip_speed 1e-7", "stiffness 1e8 N/m", "authors' viscosity", "authors' viscosity, thrown", "two hundred rollers",
    "creeping on a slope", "creeping more slowly", "creeping on bristles", "tip-over", "no damping",
    "sliding down a slope",
)  # fmt: skip


@pytest.fixture(
    scope="module",
    params=[pytest.param(case, id=case.name, marks=[pytest.mark.long] * (case.name in LONG)) for case in CASES],
)
def case(request):
    """All tests of a case follow each other, so that one process runs it for them."""
    return request.param


@cache
def row(case):
    """Each case runs once for all tests."""
    return hard_cases.row(case)


def test_a_hard_case_moves_as_claimed(case):
    found = row(case)
    assert found["error"] < found["bound"], found["against"]  # both stand in the table


def test_a_hard_case_reaches_its_end_or_says_why_not(case):
    status = row(case)["status"]
    assert case.stops in status if case.stops else status == "complete", status


def test_energy_is_balanced_to_1e_9(case):
    assert row(case)["energy"] < hard_cases.BALANCED  # measured at most 9e-10; it stands in the table


def test_friction_does_no_positive_work(case):
    assert row(case)["friction_power"] < 1e-11  # W, rounding; measured 4e-12 at 500 rad/s


@pytest.mark.long
def test_the_table_shows_every_case():
    rows = [row(case) for case in CASES]
    lines = hard_cases.report(rows).splitlines()
    assert len(CASES) >= LEAST
    assert [line.split(" | ")[0].strip("| ") for line in lines[2 : 2 + len(CASES)]] == [case.name for case in CASES]
    for case in CASES:
        assert any(line.startswith(f"- {case.name}: ") for line in lines) == bool(case.stops)
