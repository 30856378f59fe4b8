"""Machine code of kernels: right wherever it is put, once it is compiled and when it is loaded from disk."""

import math
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

import omnisim

KERNELS = """
import math
from omnisim.base.kernel import kernel
@kernel
def near(x):
    return 1.2345678 * x + 0.7654321
@kernel
def far(numbers):
    found = 0.0
    for x in numbers:
        found += 8.7654321 * near(x) + math.exp(x) % 100.0  # a function of Numba's own, gone once it is optimised
    return found
"""
PROGRAM = """
import sys
import numpy as np
from omnisim.base import machine_code
machine_code.IN_ONE_PIECE = sys.argv[1] == "True"
from placed import far, near
found = [near(1.0)]
if sys.platform == "linux":
    held = [np.empty(3 << 30, np.uint8) for _ in range(4)]  # 12 GiB of addresses, of which nothing is used
found += [far(np.array([0.0, 1.0])), far(np.array([[0.0, 7.0], [1.0, 7.0]])[:, 0])]
print(*found, sum(sum(kernel.entry.stats.cache_hits.values()) for kernel in (near, far)))
"""


TRIED = (sys.platform, platform.machine()) == ("linux", "x86_64")


@pytest.mark.parametrize(
    "in_one_piece", [pytest.param(True, marks=pytest.mark.skipif(not TRIED, reason="not tried here")), False]
)
def test_kernels_are_right_wherever_their_code_is(tmp_path, in_one_piece):
    """Compiled and from disk, for two kinds of arguments, with so much in memory before the second that four bytes do
    not reach from it to all that it calls."""
    paths = os.pathsep.join(map(str, (tmp_path, Path(omnisim.__file__).parents[1])))
    environment = {**os.environ, "PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    (tmp_path / "placed.py").write_text(KERNELS)
    near = [1.2345678 * x + 0.7654321 for x in (0.0, 1.0)]
    far = 8.7654321 * sum(near) + 1.0 + math.e
    for loaded in (0, 3):  # kernels from disk
        done = subprocess.run(
            [sys.executable, "-B", "-c", PROGRAM, str(in_one_piece)], env=environment, capture_output=True, text=True,
            check=True,
        )  # fmt: skip
        *found, hits = map(float, done.stdout.split())
        assert found == pytest.approx([near[1], far, far], rel=1e-15)
        assert hits == loaded
