"""What runs with every change, and what in the second stage (`pytest -m long`)."""

from collections.abc import Collection, Iterable

import pytest


def either(cases: Iterable, quick: Collection) -> list:
    """Those that are quick, and the others as long ones."""
    return [case if case in quick else pytest.param(case, marks=pytest.mark.long) for case in cases]
