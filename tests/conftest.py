"""The whole suite runs on all cores, once its kernels are compiled. And what tests of several rooms share.

One thread for linear algebra, before any test imports NumPy: the oracle solves 60 to 320 equations thousands of times.
A second thread gains nothing, and on a busy machine each solve waits for the slower of the two: ten times as long and
more.
"""

import gc
import os
import shutil
import subprocess
import sys

import pytest

for library in ("OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


COMPILE = """
import sys
from omnisim.run.warming import kinds, warm
rare = lambda kind: kind.free and kind.set_valued
warm([kind.scene for kind in kinds() if "long" in sys.argv or not rare(kind)], lambda kind: print(kind, "are ready"))
"""  # what quick tests need: those rare kinds take the most time, and only long ones march them


def is_whole(config: pytest.Config) -> bool:
    """Whether no tests are named, in the process that the user started: `pytest`, `pytest -m long`."""
    return config.args_source is config.ArgsSource.TESTPATHS and not config.option.keyword and not is_worker(config)


def is_worker(config: pytest.Config) -> bool:
    return hasattr(config, "workerinput")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """As if -n auto --dist worksteal were given. A few tests start faster in one process; -n 0 keeps all in one."""
    covered = config.getoption("cov_source", None)  # pytest-cov has looked for workers already
    if is_whole(config) and config.getoption("numprocesses", 0) is None and not covered:
        config.option.numprocesses, config.option.dist = "auto", "worksteal"


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Modules and tests stay to the end: no search for garbage goes through them, now or later."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes(config: pytest.Config) -> None:
    """Before workers start, lest each of them compile the same kernels."""
    if is_whole(config) and os.environ.get("NUMBA_DISABLE_JIT", "0") == "0":
        stage = "quick" if config.option.markexpr == "not long" else "long"
        print("compiling kernels, once, where they are not on disk ...", flush=True)
        if subprocess.run([sys.executable, "-uc", COMPILE, stage], check=False).returncode:
            pytest.exit(
                "kernels do not compile, as told above; `pytest -n 0` runs the tests all the same", returncode=1
            )


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, which the test runs in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def browser():
    """One for all pages, as playwright starts but one in a process: without a network, a graphics card or hurry."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright: pip install -e '.[test]'")
    names = ("chromium", "chromium-browser", "google-chrome")
    chromium = next(filter(None, map(shutil.which, names)), None)
    if chromium is None:
        pytest.skip("needs Chromium")
    with playwright.sync_playwright() as running:
        opened = running.chromium.launch(
            executable_path=chromium, args=["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        context = opened.new_context(offline=True)
        context.set_default_timeout(180_000)  # ms
        yield context
        opened.close()
