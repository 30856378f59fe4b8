"""Runs of packaged scenes, and their pages in a browser: each made once for all tests of pictures."""

import pytest

import omnisim
from omnisim.pictures.viewer import page

SCENES = ("coulomb_wheel", "kiwi", "mixed", "youbot", "cable_duct", "kiwi_ramp", "rocker")


class Runs(dict):
    """Trajectories by the name of their scene, each simulated when somebody asks for it."""

    def __init__(self, scenes):
        self.scenes = scenes

    def __missing__(self, name):
        self[name] = omnisim.simulate(self.scenes[name])
        return self[name]


@pytest.fixture(scope="session")
def runs():
    """Trajectories of packaged scenes by name, and of one on two rows, 100 rows a second; the mecanum machine drives
    for 10 s, that on springs begins in the air."""
    overrides = {name: ["time.output_interval=0.01"] for name in SCENES} | {"youbot": ["time.end=10.0"]}
    overrides["kiwi_ramp"].append("time.end=0.5")
    overrides["cable_duct"].append("initial.height=0.003")
    rows = "wheel_types.omni.rows=[{offset=-0.006, phase_deg=15.0}, {offset=0.015, phase_deg=-5.0}]"
    on_rows = [*overrides["kiwi"], "time.end=3.0", "wheel_types.omni.roller_count=9", rows]
    scenes = {name: omnisim.load(name, overrides[name]) for name in SCENES}
    return Runs(scenes | {"kiwi on rows": omnisim.load("kiwi", on_rows)})


@pytest.fixture(scope="session")
def youbot(runs):
    return page(runs["youbot"])


@pytest.fixture(scope="session")
def shown(runs, browser, tmp_path_factory):
    """Opens the page of a run from a file, without a network; every complaint of the browser is an error."""
    folder, pages = tmp_path_factory.mktemp("pages"), {}

    def show(name):
        if name not in pages:
            (folder / f"{name}.html").write_text(page(runs[name]), encoding="utf-8")
            tab = browser.new_page()
            tab.complaints = []
            tab.on("pageerror", lambda error: tab.complaints.append(str(error)))
            tab.on("console", lambda message: message.type == "error" and tab.complaints.append(message.text))
            tab.goto((folder / f"{name}.html").as_uri())
            tab.wait_for_function("window.omnisim")
            pages[name] = tab
        return pages[name]

    return show


@pytest.fixture(scope="session")
def kiwi():
    twist = ["command.times=[0, 0.1, 0.2]", "command.twist=[[0, 0, 0], [0.5, 0, 0], [0.5, 0, 0.5]]"]
    changes = ["time.end=1.5", "time.output_interval=0.01", "output.bearing_loads=true", *twist]
    return omnisim.simulate(omnisim.load("kiwi", changes))


@pytest.fixture(scope="session")
def wheel():
    return omnisim.simulate(omnisim.load("coulomb_wheel", ["output.bearing_loads=true"]))
