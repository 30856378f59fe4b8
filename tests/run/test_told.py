"""Datasets of a trajectory are computed when somebody asks; what has happened meanwhile changes none of them."""

import pickle

import numpy as np
import pytest

import omnisim
from omnisim import Loop

SHORT = {"time.step": 1e-3, "time.end": 0.1, "time.output_interval": 0.01}


def halfway() -> Loop:
    loop = Loop(omnisim.load("youbot", SHORT))
    loop.advance(0.035)
    return loop


def same(a, b) -> bool:
    return list(a) == list(b) and all(np.array_equal(a[path], b[path]) for path in a)


@pytest.mark.parametrize(
    "goes_on",
    [
        lambda loop: loop.advance(0.05),
        lambda loop: (loop.drive("front_left", 3.0), loop.advance(0.05)),
        lambda loop: loop.wrench((5.0, 0.0, 0.0)),
        lambda loop: (loop.drive("front_left", 3.0), loop.trajectory(), loop.advance(0.01)),
        lambda loop: loop.restore(Loop("youbot")),
        lambda loop: loop.reset({"chassis.mass": 30.0}),
        lambda loop: (loop.copy().advance(0.05), loop.advance(0.01)),
    ],
)
def test_a_loop_that_goes_on_leaves_what_it_has_told(goes_on):
    at_once = halfway().trajectory()
    assert at_once["body/position"].shape == (4, 3)  # computed
    loop = halfway()
    told = loop.trajectory()
    goes_on(loop)
    assert same(told, at_once)


def test_nothing_is_computed_before_somebody_asks():
    told = halfway().trajectory()
    assert "data" not in vars(told)
    assert told.attributes["status"].startswith("ended by its controller")
    assert "data" not in vars(told)
    assert "body/position" in told
    assert "data" in vars(told)


def test_a_trajectory_goes_to_another_process_with_its_datasets():
    told = omnisim.simulate(omnisim.load("youbot", SHORT))
    assert same(pickle.loads(pickle.dumps(told)), omnisim.simulate(omnisim.load("youbot", SHORT)))
