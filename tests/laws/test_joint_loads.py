"""What bearings carry: closed forms for a wheel at rest, spinning and sliding, the same by either formulation.

Forces and moments are those of the axle on what it carries. A machine on four omni wheels with straight rollers stands
with roller 0 of each straight below its centre, d = -n and a = -h there; the azimuth q of roller i is gamma_i - phi.
Measured values stand beside the bounds.
"""

import numpy as np
import pytest
from machines import BOX, CHASSIS, TYPES, axle_inertia, machine, wheel_mass
from machines import run as simulate

import omnisim

FORMULATIONS = ("reduced", "multibody")
KIND = TYPES["omni"]
R, R1, COUNT, ROLLER = KIND["radius"], KIND["roller_distance"], KIND["roller_count"], KIND["roller"]
WHEEL_MASS, GRAVITY = wheel_mass("omni"), 9.81
EACH = CHASSIS["mass"] / len(BOX) * GRAVITY  # of the chassis on each axle, N


@pytest.fixture(params=FORMULATIONS)
def run(request):
    """A function that runs the machine, with wheels and scene changed."""

    def simulated(wheels=None, **changed) -> omnisim.Trajectory:
        scene = machine("omni", time={"end": 0.02, "step": 1e-5, "output_interval": 0.01}, **changed)
        scene["output"], scene["solver"] = {"bearing_loads": True}, {"formulation": request.param}
        for wheel in scene["wheels"]:
            wheel |= wheels or {}
        return simulate(scene)

    return simulated


def azimuths(motion, wheel: str) -> np.ndarray:
    """q of every roller in every row (T, N_r)."""
    gamma = 2.0 * np.pi * np.arange(COUNT) / COUNT
    return gamma - motion[f"wheels/{wheel}/spin_angle"][:, None]


def loads(motion, wheel: str) -> tuple[np.ndarray, ...]:
    """Force and moment on the wheel (T, 3) and on its rollers (T, N_r, 3)."""
    paths = (f"wheels/{wheel}/{part}" for part in ("", "rollers/"))
    return tuple(motion[f"{path}bearing_{what}"] for path in paths for what in ("force", "moment"))


def test_at_rest_bearings_carry_weights(run):
    """The chassis rests on the axles, the wheel on its lowest roller, every other roller hangs in its bearing."""
    motion = run()
    for wheel in motion.wheels:
        force, moment, rollers, turning = loads(motion, wheel)
        np.testing.assert_allclose(force, np.tile([0.0, 0.0, -EACH], (len(force), 1)), atol=1e-12 * EACH)  # 2e-14
        np.testing.assert_allclose(moment, 0.0, atol=1e-14)  # measured: 2e-16
        weight, q = ROLLER["mass"] * GRAVITY, azimuths(motion, wheel)
        expected = weight * np.stack([-np.cos(q), 0.0 * q, -np.sin(q)], axis=-1)  # n along d, a x d and a
        expected[:, 0, 0] += EACH + WHEEL_MASS * GRAVITY
        np.testing.assert_allclose(rollers, expected, atol=1e-12 * EACH)
        np.testing.assert_allclose(turning, 0.0, atol=1e-14)


def test_spinning_freely_rollers_pull_outwards(run):
    """Centripetal: -m R1 phi'^2 along d; gyroscopic: a roller that spins at chi' needs -Ia chi' phi' about d."""
    rate, rolling = 80.0, 500.0
    motion = run({"spin_rate": rate, "roller_rates": rolling})
    for wheel in motion.wheels:
        force, moment, rollers, turning = loads(motion, wheel)
        np.testing.assert_allclose(force, np.tile([0.0, 0.0, -EACH], (len(force), 1)), atol=1e-11 * EACH)
        np.testing.assert_allclose(moment, 0.0, atol=1e-12)
        weight, q = ROLLER["mass"] * GRAVITY, azimuths(motion, wheel)
        pull = np.zeros((*q.shape, 3))
        pull[..., 0] = -ROLLER["mass"] * R1 * rate**2 - weight * np.cos(q)
        pull[..., 2] = -weight * np.sin(q)
        rows, lowest = np.arange(len(q)), motion[f"wheels/{wheel}/contact_roller"]
        normal, below = motion[f"wheels/{wheel}/normal_force"], q[rows, lowest]
        pull[rows, lowest, 0] += normal * np.cos(below)
        pull[rows, lowest, 2] += normal * np.sin(below)
        np.testing.assert_allclose(rollers, pull, atol=1e-9)  # of 70 N
        gyroscopic = np.zeros_like(pull)
        gyroscopic[..., 0] = -ROLLER["inertia_axial"] * rolling * rate
        gyroscopic[rows, lowest, 1] = R1 * np.sin(below) * normal  # the contact is R1 tan q beside the roller's middle
        np.testing.assert_allclose(turning, gyroscopic, atol=1e-11)  # of 0.03 N m


def test_in_pure_sliding_the_lowest_roller_hands_friction_on(run):
    """A machine thrown forwards with wheels that do not turn: at t = 0 all that moves is known."""
    friction = {"law": "coulomb", "coefficient": 0.5}
    motion = run(friction=friction, initial={"velocity": [1.0, 0.0]})
    (deceleration, *_), up = motion["body/acceleration"][0], GRAVITY
    mass = CHASSIS["mass"] + len(BOX) * WHEEL_MASS
    assert abs(deceleration + 0.5 * GRAVITY) < 1e-12 * mass  # the floor gives mu M g
    for wheel in motion.wheels:
        force, moment, rollers, turning = (load[0] for load in loads(motion, wheel))
        normal = motion[f"wheels/{wheel}/normal_force"][0]
        rubbing, spin = -0.5 * normal, motion[f"wheels/{wheel}/spin_acceleration"][0]
        expected = [WHEEL_MASS * deceleration - rubbing, 0.0, WHEEL_MASS * up - normal]
        np.testing.assert_allclose(force, expected, atol=1e-12)
        np.testing.assert_allclose(moment, 0.0, atol=1e-13)
        assert abs(axle_inertia("omni") * spin + R * rubbing) < 1e-12  # the wheel spins up under R mu N
        ahead = ROLLER["mass"] * (deceleration - R1 * spin) - rubbing  # along h = -a
        np.testing.assert_allclose(rollers[0], [normal - ROLLER["mass"] * up, 0.0, -ahead], atol=1e-12)
        about_k = ROLLER["inertia_transverse"] * spin + (R - R1) * rubbing
        np.testing.assert_allclose(turning[0], [0.0, -about_k, 0.0], atol=1e-13)  # a x d = -k


def test_a_bare_wheel_has_no_axle_to_load():
    scene = omnisim.load("coulomb_wheel", ["output.bearing_loads=true", "time.end=0.1"])
    motion = omnisim.simulate(scene)
    assert "wheels/wheel/rollers/bearing_force" in motion
    assert "wheels/wheel/bearing_force" not in motion


def test_loads_are_recorded_where_they_are_asked_for():
    motion = omnisim.simulate(omnisim.load("kiwi", ["time.end=0.1"]))
    assert not [path for path in motion if "bearing_" in path and "energy" not in path]
