"""Kernels are compiled for kinds of scenes: once for each, and for all scenes of it."""

import os
import subprocess
import sys

import pytest
from scenes import reference_scene

from omnisim.run.warming import Kind, kernels_of, kind_of, kinds
from omnisim.scene.scene import load

COUNTING = """
import sys
from numba.core import event

class Counted(event.Listener):
    count = 0
    def on_start(self, _): Counted.count += 1
    def on_end(self, _): pass

event.register("numba:compile", Counted())
import omnisim
for scene in sys.argv[1:]:
    name, *overrides = scene.split()
    Counted.count = 0
    assert omnisim.simulate(omnisim.load(name, overrides)).complete
    print(Counted.count)
"""
BARE = "six_rollers time.end=0.1"
SAME = ("thirty_two_rollers time.end=0.05", "six_rollers time.end=0.1 friction.law=saturated solver.tracking=implicit")


def compilations(*scenes):
    """How many kernels a new process compiles for each scene in turn."""
    done = subprocess.run([sys.executable, "-c", COUNTING, *scenes], capture_output=True, text=True, check=True)
    return [int(count) for count in done.stdout.split()]


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT", "0") != "0", reason="nothing is compiled")
def test_scenes_of_a_kind_share_all_kernels_and_a_new_process_compiles_none():
    compilations(BARE)
    assert compilations(BARE, *SAME) == [0, 0, 0]


def test_a_small_scene_is_of_the_kind_that_it_is_made_for():
    found = list(kinds())
    held = [kind for kind in found if not kind.free]
    assert len(held) == 10  # in the multibody formulation all steps are explicit, and it is of those that few have
    assert len(found) - len(held) == 8  # smooth or set-valued, explicit or implicit, plain or not
    for kind in found:
        assert kind_of(kind.scene) == kind


@pytest.mark.parametrize(("scene", "kind"), [
    ("kiwi_ramp", Kind(free=True)),
    ("cable_duct", Kind(free=True)),
    ("six_rollers", Kind(False, False, False)),
    ("soccer_robot", Kind(False, True, False, seldom=True)),  # motors
    ("wheel_bench", Kind(implicit=True, free=True, seldom=True)),  # rollers that resist rolling
    ("coulomb_wheel", Kind(False, True, False)),
    ("authors_vehicle", Kind(False, True, False)),  # its layer of slip is thin
    (reference_scene("testbench_psi0", "solver.method=auto", "time.step=1e-2"), Kind(False, False, True)),
])  # fmt: skip
def test_a_scene_is_of_one_kind(scene, kind):
    assert kind_of(load(scene) if isinstance(scene, str) else scene) == kind


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT", "0") != "0", reason="nothing is compiled")
def test_kernels_of_a_kind_are_those_that_it_needs():
    def names(*kind):
        return {kernel.__name__ for kernel in kernels_of(Kind(*kind))}

    smooth, coulomb, implicit, multibody = (
        names(False, False, False),
        names(False, True, False),
        names(False, False, True),
        names(True, False, False, False, True),
    )
    assert {"march", "observe", "reduced_rhs"} <= smooth < coulomb
    assert {"turn_creep", "come_to_rest", "align_slip"} <= coulomb - smooth
    assert {"implicit_step", "factorize"} <= implicit - smooth
    assert "multibody_rhs" in multibody - smooth and "reduced_rhs" not in multibody
    assert {"turn_motor", "bearing_rollers", "set_resistance", "brush_factor"} <= names(*[False] * 4, True) - smooth
    free, gripping = names(False, False, False, True), names(False, True, False, True)
    assert {"spatial_rhs", "add_contact", "touch_ground"} <= free - smooth and "reduced_rhs" not in free
    assert {"hold", "align_in_space"} <= gripping - free
