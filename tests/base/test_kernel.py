"""The cache of compiled kernels never runs stale code."""

import os
import pkgutil
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numba
import pytest
from test_imports import imported

import omnisim
from omnisim.base import kernel

PACKAGE = Path(omnisim.__file__).parent
IMPORT = "from omnisim.base.kernel import kernel\n"
PROGRAM = """
from omnisim.contact.frame import Slip
from omnisim.base.kernel import kernel, CACHE_DIRECTORY
from omnisim import caller
print(caller.outer(2.0), CACHE_DIRECTORY.name)
"""


@pytest.fixture
def package(tmp_path):
    """A copy of the package with two kernels in two files, the one calling the other."""
    copy = tmp_path / "omnisim"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "callee.py").write_text(f"{IMPORT}@kernel\ndef inner(x):\n    return 3.0 * x\n")
    (copy / "caller.py").write_text(
        f"{IMPORT}from omnisim.callee import inner\n@kernel\ndef outer(x):\n    return inner(x) + 1.0\n"
    )
    return copy


def run(package, **environment):
    environment = {**os.environ, "PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=package.parent, env=environment, capture_output=True, text=True, check=True
    )
    value, folder = result.stdout.split()
    return float(value), folder


def test_an_edit_in_a_called_file_changes_what_the_cached_caller_computes(package, tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert run(package, **cache)[0] == 7.0
    (package / "callee.py").write_text((package / "callee.py").read_text().replace("3.0", "5.0"))
    assert run(package, **cache)[0] == 11.0


def test_what_is_on_disk_is_loaded_without_what_only_compiling_needs(package, tmp_path):
    """Numba's rules of arrays, which take longer to find than a kernel to be loaded."""
    program = "import sys\nfrom omnisim import caller\nprint(caller.outer(2.0), 'numba.np.linalg' in sys.modules)"
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-B", "-c", program]
    runs = [subprocess.check_output(command, cwd=tmp_path, env=environment, text=True) for _ in range(2)]
    first, again = map(str.split, runs)
    assert first == ["7.0", "True"] and again == ["7.0", "False"]


@pytest.mark.long
def test_the_same_sources_share_one_cache_and_others_do_not(package, tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    first, again = run(package, **cache)[1], run(package, **cache)[1]
    assert first == again
    assert list((tmp_path / "cache" / "omnisim" / first).rglob("*.nbc")), "the kernels are on disk"
    (package / "base/status.py").write_text((package / "base/status.py").read_text() + "# edited\n")
    assert run(package, **cache)[1] != first


@pytest.fixture(scope="module")
def kernel_modules():
    """Paths of the modules in the hash, by name."""
    paths = (path.relative_to(PACKAGE.parent) for path in kernel.kernel_sources(PACKAGE))
    return {".".join(path.with_suffix("").parts).removesuffix(".__init__"): path for path in paths}


def test_every_module_that_defines_a_kernel_counts(kernel_modules):
    pytest.importorskip("matplotlib", reason="all modules are imported")
    names = [found.name for found in pkgutil.walk_packages([str(PACKAGE)], "omnisim.")]
    values = [value for name in names for value in vars(import_module(name)).values()]
    homes = {value.__module__ for value in values if hasattr(value, "py_func")}
    assert numba.config.DISABLE_JIT or "omnisim.march.march" in homes
    assert homes <= set(kernel_modules)


def test_whatever_these_import_counts(kernel_modules):
    every = {found.name for found in pkgutil.walk_packages([str(PACKAGE)], "omnisim.")}
    needed = {name for path in kernel_modules.values() for name in imported(PACKAGE.parent / path)}
    assert {"omnisim.base.methods", "omnisim.dynamics.parameters"} <= needed & every <= set(kernel_modules)


def test_a_key_of_the_scene_a_dataset_and_a_plot_recompile_nothing(kernel_modules):
    rooms = ("omnisim.scene", "omnisim.results", "omnisim.cad", "omnisim.pictures")
    assert not [name for name in kernel_modules if name.startswith(rooms)]


@pytest.mark.long
def test_an_edit_counts_if_a_kernel_may_see_it(package, kernel_modules):
    for path in package.rglob("*.py"):
        before, text = kernel.source_hash(package), path.read_text()
        path.write_text(text + "# edited\n")
        seen = path.relative_to(package.parent) in kernel_modules.values() or path.stem in {"caller", "callee"}
        assert (kernel.source_hash(package) != before) == seen, path
        path.write_text(text)


def test_plots_and_files_do_not_count(kernel_modules):
    away = (
        "pictures.plots.motion",
        "pictures.plots.style",
        "results.tables",
        "results.hdf5",
        "results.report",
        "pictures.viewer",
        "cad.mesh",
        "cad.mjcf",
        "cad.urdf",
        "exports.recording",
        "exports.markers",
    )
    assert not {f"omnisim.{name}" for name in away} & set(kernel_modules)


@pytest.mark.parametrize("statement", [
    "from omnisim.constants import MASS",
    "from omnisim import constants",
    "import omnisim.constants as c",
    "import math, omnisim.constants",
    "from .constants import MASS",
    "from . import constants",
    "from omnisim import (  # two (of them)\n    base,\n    constants,\n)",
    "from omnisim.constants \\\n    import MASS",
    "def late():\n    from omnisim.constants import MASS",
    "if True: from omnisim.constants import MASS",
    "from omnisim.base.records import *; from omnisim.constants import *",
])  # fmt: skip
def test_an_import_counts_however_it_is_written(statement, package):
    (package / "constants.py").write_text("MASS = 1.0\n")
    assert package / "constants.py" not in kernel.kernel_sources(package)
    (package / "callee.py").write_text(f"{IMPORT}{statement}\n")
    assert package / "constants.py" in kernel.kernel_sources(package)


@pytest.mark.long
def test_only_the_latest_caches_of_other_sources_survive(package, tmp_path):
    base = tmp_path / "cache" / "omnisim"
    for age in range(10):
        (base / f"old{age}").mkdir(parents=True)
        os.utime(base / f"old{age}", (1e9 - age, 1e9 - age))
    current = run(package, NUMBA_CACHE_DIR=str(tmp_path / "cache"))[1]
    kept = {path.name for path in base.iterdir()}
    assert kept == {current, *(f"old{age}" for age in range(kernel.KEPT_CACHES))}


@pytest.mark.long
def test_without_a_writable_folder_kernels_compile_into_a_temporary_one(package, tmp_path):
    (tmp_path / "file").write_text("")
    value, _ = run(package, NUMBA_CACHE_DIR=str(tmp_path / "file" / "below"), TMPDIR=str(tmp_path))
    assert value == 7.0
    assert list(tmp_path.glob("omnisim-*/*/**/*.nbc"))


@pytest.mark.long
def test_a_full_disk_costs_the_kept_kernels_but_not_the_result(package, tmp_path):
    program = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))" + PROGRAM
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run(
        [sys.executable, "-B", "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.stdout.startswith("7.0 "), done.stderr
    assert "compiled kernels cannot be kept: File too large" in done.stderr
    assert not list((tmp_path / "cache").rglob("*.nbc*"))


@pytest.mark.long
def test_signatures_compiled_by_two_processes_at_once_get_files_of_their_own(package, tmp_path):
    """Each process starts before the other has written anything, and Numba's own cache would number both files 1."""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    (package / "callee.py").write_text(f"{IMPORT}@kernel\ndef inner(x):\n    return x / 2\n")
    program = "from omnisim import callee; print('ready', flush=True); input(); print(callee.inner({}))"

    def start(argument):
        return subprocess.Popen(
            [sys.executable, "-B", "-c", program.format(argument)],
            cwd=tmp_path, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    both = [start(argument) for argument in ("7.0", "7")]
    assert [process.stdout.readline() for process in both] == ["ready\n"] * 2
    assert [process.communicate("\n")[0] for process in both] == ["3.5\n"] * 2
    assert len(list((tmp_path / "cache").rglob("callee.*.nbc"))) == 2


KINDS = """
from typing import NamedTuple
import numpy as np
from omnisim.base.kernel import kernel, outlined
class Wheel(NamedTuple):
    radius: float
    tilt: np.ndarray | None
class Machine(NamedTuple):
    wheel: Wheel
    mass: float
@outlined
def tilted(wheel, x):
    return wheel.tilt[0] * x  # has a type only if there is a tilt
@kernel
def flat(mass, x):
    return mass * x
@outlined
def force(machine, x):
    wheel = machine.wheel
    if wheel.tilt is not None and x > 1.0:
        return tilted(wheel, x)
    return flat(machine.mass, x) if wheel.tilt is None else FACTOR * x
"""
KINDS_PROGRAM = """
import numpy as np
from numba.core import event
from omnisim.kinds import Machine, Wheel, flat, force, tilted
class Counted(event.Listener):
    count = 0
    def on_start(self, _): Counted.count += 1
    def on_end(self, _): pass
event.register("numba:compile", Counted())
print(force(Machine(Wheel(1.0, None), 3.0), 2.0), len(tilted.overloads), len(flat.overloads), Counted.count)
print(force(Machine(Wheel(1.0, np.array([5.0])), 3.0), 2.0), len(tilted.overloads), Counted.count)
print(force(Machine(Wheel(1.0, np.array([5.0])), 3.0), 0.5))
"""


@pytest.mark.long
def test_what_is_not_there_is_not_compiled_and_every_kind_is_on_disk_afterwards(package, tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def lines(factor):
        (package / "kinds.py").write_text(KINDS.replace("FACTOR", factor))
        done = subprocess.run(
            [sys.executable, "-B", "-c", KINDS_PROGRAM], cwd=tmp_path, env=environment, capture_output=True, text=True,
            check=True,
        )  # fmt: skip
        return done.stdout.splitlines()

    assert lines("7.0") == ["6.0 0 1 2", "10.0 1 4", "3.5"]  # the second kind: force again, and tilted
    assert lines("7.0") == ["6.0 0 0 0", "10.0 0 0", "3.5"]
    assert lines("9.0")[2] == "4.5"
    assert lines("7.0") == ["6.0 0 0 0", "10.0 0 0", "3.5"]  # the older one is still there, and right


ZEROS = """
from typing import NamedTuple
import numpy as np
from omnisim.base.kernel import kernel, outlined
from omnisim.base.records import without
ANY = np.dtype([("stiffness", "f8"), ("mass", "f8"), ("rubber", "i8")])
RIGID = without(ANY, "stiffness", "rubber")
class Wheel(NamedTuple):
    material: np.record
@outlined
def squeezed(x):
    return x * x
@kernel
def force(wheel, x):
    material = wheel.material
    if material.rubber and x > 0.0:
        return squeezed(x)
    return material.stiffness * x + material.mass
"""
ZEROS_PROGRAM = """
import numpy as np
from omnisim.base.calls import direct
from omnisim.base.records import single
from omnisim.zeros import ANY, RIGID, Wheel, force, squeezed
values = np.array((5.0, 3.0, 1), ANY)
for kind in RIGID, ANY, RIGID, ANY:  # the values are of no RIGID record, so whoever looks at them is found out
    wheel = Wheel(single(kind, values))
    print(*(direct(force, wheel, x) for x in (2.0, -2.0)), len(squeezed.overloads), wheel.material.stiffness)
"""


def test_what_is_zero_in_all_records_of_a_type_is_a_constant_and_not_compiled(package, tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def lines():
        done = subprocess.run(
            [sys.executable, "-B", "-c", ZEROS_PROGRAM], cwd=tmp_path, env=environment, capture_output=True, text=True,
            check=True,
        )  # fmt: skip
        return done.stdout.splitlines()

    (package / "zeros.py").write_text(ZEROS)
    assert lines() == ["3.0 3.0 0 5.0", "4.0 -7.0 1 5.0", "3.0 3.0 1 5.0", "4.0 -7.0 1 5.0"]
    assert lines() == ["3.0 3.0 0 5.0", "4.0 -7.0 0 5.0", "3.0 3.0 0 5.0", "4.0 -7.0 0 5.0"]  # all of them from disk
    (package / "zeros.py").write_text(ZEROS.replace("material.rubber", "material.ruber"))
    with pytest.raises(subprocess.CalledProcessError) as failed:
        lines()
    assert "KeyError: 'ruber'" in failed.value.stderr  # a name that no record has is no zero


LONG = "    x = math.sin(x) * places[1]\n" * 40  # so long that LLVM makes it part of nothing by itself
GIVEN = f"""
import math
from omnisim.base.kernel import kernel, outlined
@outlined
def second(places, x):
{LONG}    return x
@kernel
def outer(places, x, y):
    return second(places, x) + y
"""
GIVEN_PROGRAM = """
import numba
import numpy as np
from omnisim.given import outer, second
found = outer(np.array([1.0, 2.0]), 3.0, 4.0)
(result,) = outer.entry.overloads.values()
print([len(list(one.arguments)) for one in result.library.get_defined_functions() if "second" in one.name])
print(numba.njit(lambda places, x: second(places, x) + 4.0)(np.array([1.0, 2.0]), 3.0) == found)
"""


@pytest.mark.long
def test_an_outlined_kernel_is_given_what_it_uses_and_no_more(package, tmp_path):
    """Of an array the place of its numbers; and where to put the result: 3 arguments, of 10 as Numba has them, which
    code that is no kernel goes on to hand over."""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    (package / "given.py").write_text(GIVEN)
    done = subprocess.run(
        [sys.executable, "-B", "-c", GIVEN_PROGRAM], cwd=tmp_path, env=environment, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    assert done.stdout.splitlines() == ["[3]", "True"]


GONE = """
from omnisim.base.kernel import kernel, outlined
@kernel
def leaf(x):
    return 3.0 * x
@kernel
def first(x):
    return leaf(x) + 1.0
@kernel
def never(x):
    return leaf(x) + 2.0
@outlined
def whole(x):
    x = first(x)
    for _ in range(0):
        x = never(x)
    return x
"""


def test_what_a_call_that_never_comes_also_needs_is_linked(package, tmp_path):
    """`leaf` is called by a kernel that LLVM drops and by one that it keeps: a call to nowhere crashes."""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    (package / "gone.py").write_text(GONE)
    program = "from omnisim.gone import whole; print(whole(2.0))"
    done = subprocess.run(
        [sys.executable, "-B", "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, "7.0\n")


def test_other_packages_keep_their_own_cache_setting():
    assert os.environ.get("NUMBA_CACHE_DIR", "") == numba.config.CACHE_DIR
