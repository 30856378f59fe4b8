"""The oracle of a bare wheel against reference trajectories, and against laws that hold whatever it assumes.

Measured values stand beside the bounds.
"""

from copy import deepcopy

import numpy as np
import pytest

from oracle.cases import agree, kinetic_rate, load
from oracle.machine import Machine
from oracle.multibody import simulate, start


@pytest.mark.long
def test_straight_rollers_follow_the_reference():
    agree("testbench_psi0", 0.5)  # measured: positions 7e-15, angles 8e-14, velocities 9e-13


@pytest.mark.long
def test_angled_rollers_follow_the_reference():
    agree("testbench_psi30", 0.3)  # two exchanges to 0.5 s: positions 5e-14, angles 1e-12, velocities 4e-12


@pytest.mark.long
def test_straight_rollers_follow_the_whole_reference():
    agree("testbench_psi0", 2.0)  # positions 3e-13, angles 1e-11, velocities 3e-11, roller rates 4e-9


@pytest.mark.long
def test_angled_rollers_follow_half_of_the_reference():
    agree("testbench_psi30", 3.0)  # positions 4e-12, angles 9e-12, velocities 6e-12, roller rates 3e-10


def busy_scene() -> dict:
    """Angled rollers that all spin, a drive with a jump, a wrench that turns with the wheel."""
    scene, _ = load("testbench_psi30")
    rates = [3.0, -8.0, 5.0, 1.0]
    drive = {"kind": "torque", "times": [0.0, 0.03, 0.03, 0.1], "torque": [0.5, 0.5, -1.0, 0.2]}
    scene["wheels"][0] |= {"roller_rates": rates, "phase_deg": 20.0, "drive": drive}
    scene["wrench"] = {"frame": "body", "times": [0.0, 0.1], "force": [[1.0, -2.0, 3.0], [4.0, 1.0, -5.0]]}
    scene["wrench"]["yaw_torque"] = [0.02, -0.03]
    return scene


def test_lowest_point_is_the_minimum_of_the_roller_surface():
    [wheel] = Machine(busy_scene()).wheels
    q = np.linspace(-wheel.half_pitch, wheel.half_pitch, 200001)
    h = wheel.radius - wheel.roller_distance / np.cos(q)
    u = wheel.roller_distance * np.tan(q) / wheel.cos_psi + h * wheel.cos_psi * np.sin(q)
    r = h * np.sqrt(1.0 - (wheel.cos_psi * np.sin(q)) ** 2)
    for rise in (-0.5, -0.2, 0.0, 0.1, 0.6):
        axis = np.array([0.6 * np.sqrt(1.0 - rise**2), 0.8 * np.sqrt(1.0 - rise**2), rise])
        heights = u * rise - r * np.sqrt(1.0 - rise**2)
        point, at = wheel.lowest_point(axis)
        assert abs(point[2] - heights.min()) < 1e-11  # measured: 3e-13, the spacing of the grid
        assert abs(point[2] + wheel.radius - wheel.roller_distance * np.cos(at)) < 1e-15


def test_constraints_survive_an_exchange_under_load():
    viscous = {"law": "viscous", "viscosity": 5.0}
    motion = simulate(busy_scene() | {"friction": viscous}, [0.0, 0.15, 0.3])
    assert len(motion["exchange_times"]) == 1
    assert motion["constraint_residual"].max() < 1e-12  # measured: 7e-15


@pytest.mark.long
def test_results_do_not_depend_on_the_tolerance():
    fine, coarse = (simulate(busy_scene(), [0.0, 0.05], rtol) for rtol in (1e-13, 1e-11))
    for key in ("position", "velocity", "yaw", "spin_angle", "normal_force", "servo_torque"):
        np.testing.assert_allclose(coarse[key], fine[key], rtol=1e-8, atol=1e-10, err_msg=key)


def test_joints_floor_and_servo_do_no_work():
    """Without friction the kinetic energy changes by the power of drive and wrench alone."""
    scene = busy_scene() | {"friction": {"law": "none"}}
    machine = Machine(scene)
    state, contacts = start(machine)
    bodies = machine.bodies(state)
    rate = kinetic_rate(machine, bodies, machine.solve(0.0, bodies, machine.mode(0.0, contacts)))
    row, wheel = simulate(scene, [0.0]), scene["wheels"][0]
    [velocity] = row["velocity"]
    power = 0.5 * wheel["spin_rate"] + 0.02 * row["yaw_rate"][0]
    power += np.dot([1.0, -2.0], velocity)  # at yaw 0, h = x and k = y
    assert abs(rate - power) < 1e-11  # of 4.8 W; measured: 1e-14


def test_centre_of_mass_obeys_the_external_forces():
    """Without friction: M V' = f in the floor plane, and N carries weight less lift."""
    scene = busy_scene() | {"friction": {"law": "none"}}
    scene["wrench"] = {"times": [0.0, 0.1, 0.1, 0.2], "force": [[2, 0, 1], [4, 1, 1], [-3, 0, 5], [-3, 0, 5]]}
    motion = simulate(scene, [0.0, 0.1, 0.2])
    impulse = [[0.0, 0.0], [0.3, 0.05], [0.0, 0.05]]
    np.testing.assert_allclose(motion["velocity"], [0.6, 0.15] + np.array(impulse) / 2.6, rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion["normal_force"], 2.6 * 9.81 - np.array([1.0, 5.0, 5.0]), rtol=1e-12)


@pytest.mark.long
def test_mirrored_wheel_moves_as_the_mirror_image():
    """Reflection in the plane of h and n: psi, roller rates, V_y, yaw, F_k and lambda change sign."""
    scene = busy_scene()
    del scene["wrench"]
    image = deepcopy(scene)
    image["wheels"][0] |= {"mirrored": True, "roller_rates": [-3.0, 8.0, -5.0, -1.0]}
    image["initial"] |= {"velocity": [0.6, -0.15], "yaw_rate": -0.5}
    one, other = simulate(scene, [0.0, 0.1]), simulate(image, [0.0, 0.1])
    for key in ("yaw", "yaw_acceleration", "servo_torque", "roller_axial_rate"):
        np.testing.assert_allclose(other[key], -one[key], rtol=1e-9, atol=1e-10, err_msg=key)
    for key in ("position", "acceleration", "friction_force"):
        np.testing.assert_allclose(other[key], one[key] * [1.0, -1.0], rtol=1e-9, atol=1e-10, err_msg=key)
    np.testing.assert_allclose(other["spin_angle"], one["spin_angle"], rtol=1e-11)


def test_a_lifted_wheel_is_refused():
    scene = busy_scene()
    scene["wrench"] = {"times": [0.0, 0.1], "force": [[0.0, 0.0, 0.0], [0.0, 0.0, 30.0]]}  # weight 25.5 N
    with pytest.raises(ValueError, match="lifts off"):
        simulate(scene, [0.0, 0.1])


@pytest.mark.parametrize(("spin_rate", "roller"), [(2.0, 1), (-2.0, 0)])
def test_on_an_edge_the_spin_chooses_the_roller(spin_rate: float, roller: int):
    """At phi = alpha roller 0 stands at q = -alpha, roller 1 at +alpha; phi' > 0 moves both to smaller q."""
    scene, _ = load("testbench_psi30")
    scene["wheels"][0] |= {"spin_angle_deg": 45.0, "spin_rate": spin_rate}
    motion = simulate(scene, [0.0, 0.01])
    assert list(motion["contact_roller"]) == [roller, roller]
