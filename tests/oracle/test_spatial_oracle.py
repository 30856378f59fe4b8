"""The oracle of machines free in space by itself: loads and motions of the references, and the laws of mechanics.

The laws hold at states of all kinds: standing, leaning, on bumps, springs and rockers.
"""

import numpy as np
import pytest

from oracle.spatial.bodies import Coordinates, Z, placed, turned
from oracle.spatial.ground import Ground
from oracle.spatial.machine import Machine
from oracle.spatial.motion import energy, half, march, multiplied, packed, rates, start, unpacked
from oracle.spatial.states import REFERENCES, SCENES, load, machine_of, rockers, states, unlike
from oracle.vectors import cross

TIME = 0.1  # of the tables, s
H = 2e-6  # of differences along the motion, s
# of a march whose events nobody locates; measured on the four: 1.4e-12, 2.2e-12, 6.5e-11, 1.4e-10, 1.4e-9, 4.7e-9
BOUNDS = {"position": 1e-10, "quaternion": 1e-10, "spin_angle": 1e-9, "velocity": 1e-9, "angular_velocity": 1e-8}
BOUNDS |= {"spin_rate": 1e-8}


@pytest.fixture(scope="module", params=["double_row", "unlike wheels", "rockers", "ribs", "grid"])
def solved(request):
    """A machine, and five states with what it finds in them."""
    machine = machine_of(SCENES[request.param])
    return machine, [(now, machine.solve(TIME, now)) for now in states(machine, 1, 5)]


@pytest.mark.parametrize("name", ["kiwi_slope", "mecanum_bump", "double_row"])
def test_wheels_carry_the_loads_of_the_reference(name):
    """In every row: rubber sees the pose, its rate and the spin. Of springs the rate is not told."""
    scene, reference = load(name)
    machine = Machine(scene)
    for row in range(len(reference["time"])):
        now = told(machine, reference, row)
        touches = machine.touches(placed(machine.layout, now))
        loads = [sum(touch.load for touch in touches if touch.wheel == w) for w in range(len(machine.wheels))]
        expected = [reference["normal_force"][wheel.name][row] for wheel in machine.wheels]
        # of 250 N; measured: 4e-12
        np.testing.assert_allclose(loads, expected, rtol=0, atol=1e-10, err_msg=f"row {row}")


def told(machine: Machine, reference: dict, row: int) -> Coordinates:
    """A row of a reference; it knows no roller rates, which do not press."""
    body = {key: np.array(reference[key][row]) for key in ("position", "quaternion", "velocity", "angular_velocity")}
    names = [wheel.name for wheel in machine.wheels]
    spins = {key: np.array([reference[key][name][row] for name in names]) for key in ("spin_angle", "spin_rate")}
    return start(machine)._replace(**body, **spins)


def test_springs_begin_with_the_loads_of_the_reference():
    scene, reference = load("mecanum_springs")
    machine = Machine(scene)
    loads = {machine.wheels[touch.wheel].name: touch.load for touch in machine.solve(0.0, start(machine)).touches}
    for name, load_ in loads.items():
        assert abs(load_ - reference["normal_force"][name][0]) < 1e-10, name  # measured: 2e-12
    assert len(loads) == 4


@pytest.mark.long
@pytest.mark.parametrize("name", REFERENCES)
def test_the_oracle_moves_as_the_reference_does(name):
    """Up to its second row."""
    scene, reference = load(name)
    machine = Machine(scene)
    now = march(machine, reference["time"][:2], 1e-9)[1]
    row = told(machine, reference, 1)
    for key, bound in BOUNDS.items():
        error = np.abs(getattr(now, key) - getattr(row, key)).max()
        assert error < bound, (key, error)


def test_energy_changes_by_the_powers_that_are_told(solved):
    machine, found = solved
    for now, reactions in found:
        told = energy(machine, TIME, now, reactions)
        assert abs(told.imbalance) < 1e-12 * max(abs(told.kinetic_rate), 1.0)  # measured: 4e-14 of up to 160 W


def test_energies_are_the_integrals_of_their_rates(solved):
    """Central differences along the motion: of kinetic, potential and elastic energy."""
    machine, found = solved
    for now, reactions in found:
        told = energy(machine, TIME, now, reactions)
        ahead, behind = (energy(machine, TIME, moved(machine, now, reactions, step), reactions) for step in (H, -H))
        for name in ("kinetic", "gravity"):
            change = (getattr(ahead, name) - getattr(behind, name)) / (2.0 * H)
            assert abs(change - getattr(told, f"{name}_rate")) < 1e-6, name  # W, measured: 6e-8


def moved(machine: Machine, now: Coordinates, reactions, step: float) -> Coordinates:
    """The state a short while later, to third order in position: accelerations held."""
    middle = packed(now) + 0.5 * step * packed(rates(now, reactions))
    later = packed(now) + step * packed(rates(unpacked(machine, middle), reactions))
    return unpacked(machine, later)


def test_bodies_accelerate_as_their_joints_let_them(solved):
    """Velocities where coordinates put them, differenced along the motion: the rows of the joints miss nothing."""
    machine, found = solved
    for now, reactions in found:
        ahead, behind = (placed(machine.layout, moved(machine, now, reactions, step)) for step in (H, -H))
        linear, turning = (ahead.v - behind.v) / (2.0 * H), (ahead.w - behind.w) / (2.0 * H)
        # measured: 2e-8 of the largest
        np.testing.assert_allclose(linear, reactions.bodies[:, :3], rtol=0, atol=1e-7 * size(reactions.bodies[:, :3]))
        np.testing.assert_allclose(turning, reactions.bodies[:, 3:], rtol=0, atol=1e-7 * size(reactions.bodies[:, 3:]))


def test_contacts_deepen_at_the_rate_that_is_told(solved):
    machine, found = solved
    for now, reactions in found:
        ahead, behind = (depths(machine, moved(machine, now, reactions, step)) for step in (H, -H))
        for touch in reactions.touches:
            which = touch.wheel, touch.roller, touch.piece
            if which in ahead and which in behind:
                assert abs((ahead[which] - behind[which]) / (2.0 * H) - touch.depth_rate) < 1e-7  # m/s, measured: 7e-9


def size(vectors: np.ndarray) -> float:
    return max(float(np.abs(vectors).max()), 1.0)


def depths(machine: Machine, now: Coordinates) -> dict:
    return {
        (touch.wheel, touch.roller, touch.piece): touch.depth for touch in machine.touches(placed(machine.layout, now))
    }


def test_momenta_change_by_what_acts_from_outside(solved):
    """Weight, ground and wrench: what acts between bodies drops out of the sums, about the origin of the world."""
    machine, found = solved
    for now, reactions in found:
        bodies, mass = placed(machine.layout, now), machine.layout.mass[:, None]
        force, moment = mass * reactions.bodies[:, :3], reactions.bodies[:, 3:, None]
        spun = (bodies.inertia @ moment)[..., 0] + cross(bodies.w, (bodies.inertia @ bodies.w[:, :, None])[..., 0])
        loads = machine.loads(TIME, bodies)
        points = np.array([*(touch.point for touch in reactions.touches), bodies.x[0], *bodies.x])
        acting = np.array([*(touch.force for touch in reactions.touches), loads.force, *(mass * machine.gravity)])
        np.testing.assert_allclose(force.sum(axis=0), acting.sum(axis=0), rtol=0, atol=1e-10)
        gained = (cross(bodies.x, force) + spun).sum(axis=0)
        expected = cross(points, acting).sum(axis=0) + loads.torque
        np.testing.assert_allclose(gained, expected, rtol=0, atol=1e-10)  # N, N m, measured: 4e-13


def test_a_machine_in_the_air_falls():
    """Its momentum is the weight's, its angular momentum about the centre of mass stays, whatever turns in it."""
    scene = unlike()
    del scene["wrench"]
    machine = machine_of(scene)
    for now in states(machine, 2, 3):
        now = now._replace(position=now.position + Z)
        found, bodies, mass = machine.solve(TIME, now), placed(machine.layout, now), machine.layout.mass
        assert not found.touches
        np.testing.assert_allclose(mass @ found.bodies[:, :3] / mass.sum(), machine.gravity, rtol=0, atol=1e-12)
        arm = bodies.x - mass @ bodies.x / mass.sum()
        change = cross(arm, mass[:, None] * found.bodies[:, :3]) + (bodies.inertia @ found.bodies[:, 3:, None])[..., 0]
        change += cross(bodies.w, (bodies.inertia @ bodies.w[:, :, None])[..., 0])
        np.testing.assert_allclose(change.sum(axis=0), np.zeros(3), rtol=0, atol=1e-11)  # N m, measured: 4e-14


def test_a_scene_that_is_turned_turns_what_is_found():
    """By a yaw: bumps, uphill direction, pose and rates. What is counted in the machine does not change."""
    yaw = 2.1
    turn = turned(Z, yaw)
    for scene in (unlike(), rockers()):
        machine, image = machine_of(scene), machine_of(scene | {"floor": turned_floor(scene["floor"], yaw)})
        for now in states(machine, 3, 2):
            vectors = {key: turn @ getattr(now, key) for key in ("position", "velocity", "angular_velocity")}
            there = now._replace(**vectors, quaternion=multiplied(half(Z, yaw), now.quaternion))
            one, other = machine.solve(TIME, now), image.solve(TIME, there)
            np.testing.assert_allclose(other.acceleration, turn @ one.acceleration, rtol=0, atol=1e-10)
            np.testing.assert_allclose(other.angular_acceleration, turn @ one.angular_acceleration, rtol=0, atol=1e-9)
            np.testing.assert_allclose(other.spin, one.spin, rtol=0, atol=1e-9)  # rad/s^2, measured: 1e-11
            np.testing.assert_allclose(other.travel, one.travel, rtol=0, atol=1e-9)
            assert len(one.touches) == len(other.touches) > 0


def turned_floor(floor: dict, yaw: float) -> dict:
    places = [turned(Z, yaw)[:2, :2] @ bump[:2] for bump in floor["bumps"]]
    bumps = [[*place, *bump[2:]] for place, bump in zip(places, floor["bumps"], strict=True)]
    return floor | {"bumps": bumps, "uphill_deg": floor["uphill_deg"] + np.degrees(yaw)}


def test_contacts_are_common_normals(solved):
    """P against the whole surface of its roller, X against the ground, P - X against its normal."""
    machine, found = solved
    for now, reactions in found[:2]:
        bodies = placed(machine.layout, now)
        for touch in reactions.touches:
            wheel, body = machine.wheels[touch.wheel], machine.layout.rollers[touch.wheel].start + touch.roller
            nu = touch.normal
            if touch.piece == 0:
                slope = np.array([*-machine.ground.gradient(*touch.point[:2]), 1.0])
                np.testing.assert_allclose(nu, slope / np.linalg.norm(slope), rtol=0, atol=1e-14)
                assert abs(touch.point[2] - machine.ground.height(*touch.point[:2])) < 1e-15
            surface = surface_of(wheel, bodies.x[body], bodies.axis[body], nu)
            deepest = -np.min((surface - touch.point) @ nu)
            assert -1e-12 < touch.depth - deepest < 1e-6  # of 3e-4 m


def surface_of(wheel, centre: np.ndarray, axis: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Points of a roller towards -nu: where the axis rises by every s, and around it."""
    across = cross(axis, cross(axis, nu))
    across, side = across / np.linalg.norm(across), cross(axis, nu) / np.linalg.norm(cross(axis, nu))
    leans = np.linspace(-1.0, 1.0, 801)
    u, r = np.array([part.profile.lowest(s) for part in wheel.parts for s in leans]).T
    angle = np.linspace(-0.5, 0.5, 101)[:, None, None]
    return (centre + u[:, None] * axis + r[:, None] * (np.cos(angle) * across + np.sin(angle) * side)).reshape(-1, 3)


def test_edges_are_met_on_their_arcs_and_faces():
    machine, met = machine_of(SCENES["ribs"]), set()
    for now in states(machine, 4, 10):
        for touch in machine.touches(placed(machine.layout, now)):
            if touch.piece:  # an edge
                step = machine.ground.steps[touch.piece - 1]
                foot = machine.ground.below(step, *(touch.point + 0.5 * step.width * step.up)[:2])
                arm = touch.point - step.centre - foot * Z
                arm = arm - (arm @ cross(Z, step.up)) * cross(Z, step.up)
                on_face = touch.normal[2] == 0.0
                expected = step.e * touch.normal if not on_face else -step.e * step.up + arm[2] * Z
                np.testing.assert_allclose(arm, expected, rtol=0, atol=1e-15)
                met.add("face" if on_face else "arc")
    assert met >= {"arc"}


def test_ground_has_the_gradient_and_hessian_of_its_height():
    grid = machine_of(SCENES["grid"]).ground.parts
    ground = Ground([*Ground.of({"bumps": [[0.1, -0.2, 0.03, 0.15], [0.3, 0.0, -0.02, 0.2]]}).parts, *grid], [])
    for x, y in [(0.0, 0.0), (0.17, -0.11), (0.4, 0.1)]:
        steps = 1e-5 * np.eye(2)
        slope = [(ground.height(x + dx, y + dy) - ground.height(x - dx, y - dy)) / 2e-5 for dx, dy in steps]
        bend = [(ground.gradient(x + dx, y + dy) - ground.gradient(x - dx, y - dy)) / 2e-5 for dx, dy in steps]
        np.testing.assert_allclose(ground.gradient(x, y), slope, rtol=0, atol=1e-9)
        np.testing.assert_allclose(ground.hessian(x, y), bend, rtol=0, atol=1e-7)
