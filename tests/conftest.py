"""Before any test imports NumPy: one thread for linear algebra. And the folder that tests of the command run in.

The oracle solves some 200 to 320 equations ten thousand times. A second thread gains nothing, and on a busy machine
each solve waits for the slower of the two: ten times as long and more.
"""

import os

import pytest

for library in ("OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, which the test runs in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
