"""Slip within slip_speed of the saturated law, where method "auto" takes it for relaxed: v = -slip_speed F / (mu N).

The authors' vehicle, thrown ahead while it turns: wheels let go and stop 48 times at exchanges. Method radau5 follows
the relaxation itself.
"""

from functools import cache

import numpy as np
import pytest
from scenes import packed

import omnisim
from omnisim.march.stiffness import explanation
from omnisim.results.comparison import distance, energy_error

THROWN = ("initial.velocity=[1.0, 0.0]", "time.end=2.0")
JUMPS = "{kind='torque', times=[0.0, 0.3, 0.3, 1.0], torque=[0.0, 0.01, -0.02, 0.01]}"
COULOMB = ("solver.method=rk4", "time.step=2e-4", "friction={law='coulomb', coefficient=0.85}")


def scene(method="auto", step=5e-4, slip_speed=1e-6, *more):
    solver = f"solver.method={method}", f"time.step={step!r}", f"friction.slip_speed={slip_speed!r}"
    return omnisim.load("authors_vehicle", [*THROWN, *solver, *more])


@cache
def run(*asked):
    found = omnisim.simulate(scene(*asked))
    assert found.complete, found.attributes["status"]
    return found


def test_it_moves_as_implicit_steps_do_at_a_sixth_of_their_cost():
    found, followed = run(), run("radau5", 1e-3)
    assert distance(found, followed) < 2.5e-8  # measured 1.05e-8
    assert found.attributes["rhs_evaluations"] < 0.17 * followed.attributes["rhs_evaluations"]  # measured 0.156
    assert energy_error(found).absolute < 2e-9 * energy_error(found).scale  # measured 8.7e-10
    assert found.attributes["method"] == "rk4"


def test_slip_is_what_friction_relaxes_it_to():
    """At the rows at which a wheel does not slide; a force of 1e-6 of the limit counts as much as rounding."""
    found, held = run(), 0
    for name in found.wheels:
        slip, force = found[f"wheels/{name}/slip_velocity"], found[f"wheels/{name}/friction_force"]
        normal = found[f"wheels/{name}/normal_force"]
        within = np.hypot(*slip.T) < 0.999e-6
        held += within.sum()
        assert np.abs(slip + 1e-6 * force / (0.85 * normal[:, None]))[within].max() < 1e-11  # m/s; measured 5e-12
    assert held > 200  # of 303


@pytest.mark.parametrize(
    ("change", "bound"),
    [  # measured: 4.9e-9, 1.8e-9, 7.8e-9
        (("floor={slope_deg=3.0}",), 2e-8),
        (tuple(f"wheels.{w}.drive={{kind='rate', rate=4.0, proportional=0.05}}" for w in "abc"), 1e-8),
        (tuple(f"wheels.{w}.drive={JUMPS}" for w in "abc"), 3e-8),
    ],
)
def test_forces_along_a_slope_of_controllers_and_that_jump_are_followed(change, bound):
    apart = distance(
        run("auto", 5e-4, 1e-6, *change, "time.end=1.0"), run("radau5", 5e-4, 1e-6, *change, "time.end=1.0")
    )
    assert apart < bound


def test_none_ever_sticks():
    assert set(run()["events/kind"]) == {"exchange"} == set(run("radau5", 1e-3)["events/kind"])
    loop = omnisim.Loop(scene())
    for _ in range(20):
        loop.advance(0.01)
        assert not loop.sticking.any()


def test_what_is_not_told_of_the_way_through_it_is_a_hundredth_of_it():
    """Of 1e-6 m/s, with steps so short that nothing else errs."""
    assert distance(run("auto", 1e-4), run("radau5", 1e-3)) < 2e-8  # measured 9.7e-9


def test_a_layer_is_thin_for_a_small_error_only_if_it_is_thinner():
    assert packed(scene("auto", 5e-4, 1e-7, "solver.error=1e-7"))[0].machine.slip_layer == 1e-7
    assert packed(scene("auto", 5e-4, 1.1e-7, "solver.error=1e-7"))[0].machine.slip_layer == 0.0
    assert packed(scene("auto", 5e-4, 1.1e-6))[0].machine.slip_layer == 0.0


def test_it_tends_to_coulomb_at_first_order_in_the_slip_speed():
    """By steps whose errors, of sub-steps of different fineness, are no part in a thousand of what lies between."""
    coulomb = omnisim.simulate(omnisim.load("authors_vehicle", [*THROWN, *COULOMB]))
    apart = [distance(run("auto", 2e-4, speed), coulomb) for speed in (1e-6, 1e-7, 1e-8)]
    assert np.diff(np.log10(apart)) == pytest.approx(-1.0, abs=1e-3)  # measured 6.247 s times the slip speed, each


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ((), "rk4: friction relaxes slip at up to 1e+08 1/s within slip_speed, at once for this step"),
        (("auto", 5e-4, 1e-5), "rk4 + radau5"),  # too thick
        (("auto", 5e-4, 1e-6, "solver.formulation=multibody", "solver.method=rk4"), "the run stops where it must"),
        (("rk4",), "the run stops where it must"),
        (("radau5",), "every step implicit"),
    ],
)
def test_info_says_where_slip_is_taken_for_relaxed(asked, words):
    config = scene(*asked).config
    assert words in explanation(config, packed(scene(*asked))[0])
