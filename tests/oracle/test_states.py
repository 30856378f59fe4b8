"""What a run says of itself against one dense solve of all free bodies and multipliers, at many of its states.

The states are those of the engine's own run, on both sides of every event among them, so that nothing has to be marched
twice. Where friction has a law of the oracle, that is solved for too; else the oracle is given the forces of friction
and the torques of the drives, and finds what they do. Measured values stand beside the bounds.
"""

import numpy as np
import pytest

import omnisim
from oracle.machine import Machine
from oracle.scenes import (
    BARE_ROWS,
    BASE,
    CASES,
    HEAVY,
    LAWS,
    MACHINES,
    MECANUM,
    MOVING,
    PUSHED,
    ROWS,
    SKEW,
    following,
    resisting,
)
from oracle.states import Given, states
from oracle.vectors import AXIS, POSITION, ROTATION, UP, VELOCITY, cross

COULOMB = "friction={law='coulomb', coefficient=0.4}"
SLOPE = "floor={slope_deg=8.0, uphill_deg=110.0}"
FINE = "time={end=0.12, step=2e-5, output_interval=2e-5}"
LONGER = "time={end=0.5, step=1e-4, output_interval=1e-4}"
RESISTING = resisting("straight", "tilted", "crossed")
BODIES = "solver.formulation=multibody"
DRIVEN = "time={end=1.0, step=1e-3, output_interval=1e-3}"
# path, overrides, and whether the oracle solves for friction too
SCENES = {f"bare wheel, {name}": (BASE, [*MOVING, *overrides, LONGER], Machine) for name, overrides in CASES.items()}
for name, (path, overrides) in MACHINES.items():
    SCENES |= {f"{name}, {law}": (path, [*overrides, f"friction.law={law}", FINE], Machine) for law in LAWS}
SCENES |= {
    "bare wheel, coulomb": ("coulomb_wheel", ["wheel_types.omni.roller_angle_deg=30", *PUSHED[1:], LONGER], Given),
    "bare wheel on a slope, coulomb": ("coulomb_wheel", [SLOPE, LONGER], Given),
    "bare wheel, implicit tracking": (BASE, [*MOVING, "solver.tracking=implicit", LONGER], Machine),
    "three skew wheels, coulomb": (SKEW, [COULOMB, FINE], Given),
    "three skew wheels on a slope, implicit tracking": (SKEW, [SLOPE, "solver.tracking=implicit", FINE], Machine),
    "four mecanum wheels, coulomb": (MECANUM, [*HEAVY, COULOMB, FINE], Given),
    "four mecanum wheels on a servo, coulomb": (MECANUM, [*HEAVY, COULOMB, "scene.upright=servo", FINE], Given),
    "bare wheel on two rows, coulomb": ("coulomb_wheel", [*BARE_ROWS, *PUSHED[1:], LONGER], Given),
    "three skew wheels on rows, coulomb": (SKEW, [*ROWS, COULOMB, FINE], Given),
    "three skew wheels on rows and a servo, coulomb": (SKEW, [*ROWS, COULOMB, "scene.upright=servo", FINE], Given),
    "three skew wheels on rows and a slope, implicit tracking": (
        SKEW,
        [*ROWS, SLOPE, "solver.tracking=implicit", FINE],
        Machine,
    ),
    "three skew wheels on rows that follow angles, coulomb": (
        SKEW,
        [*ROWS, *following("front", "left", "right"), COULOMB, FINE],
        Given,
    ),
    "bare wheel that resists rolling": (BASE, [*MOVING, *resisting("omni"), LONGER], Machine),
    "bare wheel that resists rolling, as bodies": (BASE, [*MOVING, *resisting("omni"), BODIES, LONGER], Machine),
    "bare wheel that resists rolling, coulomb": ("coulomb_wheel", [*resisting("omni"), *PUSHED[1:], LONGER], Given),
    "three skew wheels that resist rolling": (SKEW, [*RESISTING, FINE], Machine),
    "the same, viscous": (SKEW, [*RESISTING, "friction.law=viscous", FINE], Machine),
    "the same, creeping on a servo": (SKEW, [*RESISTING, "friction.law=brush", "scene.upright=servo", FINE], Machine),
    "the same on rows, as bodies": (SKEW, [*ROWS, *RESISTING, BODIES, FINE], Machine),
    "the same, coulomb": (SKEW, [*RESISTING, COULOMB, FINE], Given),
    "the same, coulomb, as bodies": (SKEW, [*RESISTING, COULOMB, BODIES, FINE], Given),
    "the same, coulomb, on a servo": (SKEW, [*RESISTING, COULOMB, "scene.upright=servo", FINE], Given),
    "the same, coulomb, following angles": (
        SKEW,
        [*following("front", "left", "right"), *RESISTING, COULOMB, FINE],
        Given,
    ),
    "four mecanum wheels that resist rolling, coulomb": (
        MECANUM,
        [*HEAVY, *resisting("mecanum"), COULOMB, FINE],
        Given,
    ),
    "kiwi under control": ("kiwi", [DRIVEN], Given),
    "mixed wheels under control": ("mixed", [DRIVEN], Given),
    "three skew wheels that follow angles": (SKEW, [*following("front", "left", "right"), FINE], Given),
    "three skew wheels that follow angles, coulomb": (
        SKEW,
        [*following("front", "left", "right"), COULOMB, FINE],
        Given,
    ),
    "two of four mecanum wheels follow angles": (
        MECANUM,
        [*HEAVY, *following("front_right", "rear_left"), FINE],
        Given,
    ),
    "youbot under control": ("youbot", [DRIVEN, "command.twist=[[0, 0, 0], [0.3, 0.2, 0.5]]"], Given),
}


class Pairs(dict):
    """By quantity: what the oracle says and what the run says, at all states."""

    def add(self, name, theirs, ours):
        self.setdefault(name, []).append((theirs, ours))

    def difference(self, name):
        """The largest, SI units; relative, where there are values above 1."""
        theirs, ours = (np.concatenate([np.ravel(pair[side]) for pair in self[name]]) for side in (0, 1))
        return np.abs(theirs - ours).max() / max(np.abs(theirs).max(), 1.0)


def add_body(pairs, machine, run, state):
    told, row = state.told, state.row
    for name in ("position", "velocity", "acceleration"):
        pairs.add(name, told[name], run[f"body/{name}"][row, :2])
    pairs.add("yaw acceleration", told["yaw_acceleration"], run["body/yaw_acceleration"][row])
    pairs.add("kinetic energy", told["kinetic"], run["energy/kinetic"][row])
    if machine.upright == "servo":
        path = "body/servo_torque" if machine.chassis else f"wheels/{run.wheels[0]}/servo_torque"
        pairs.add("servo torque", told["servo_torque"], run[path][row])


def add_wheel(pairs, machine, run, state, w):
    wheel, touch, row = machine.wheels[w], state.reactions.touches[w], state.row
    told, of = state.told["wheels"][wheel.name], f"wheels/{wheel.name}"
    for name in ("spin_acceleration", "normal_force", "friction_force"):
        pairs.add(name.replace("_", " "), told[name], run[f"{of}/{name}"][row])
    pairs.add("axial rate", told["roller_axial_rate"], run[f"{of}/rollers/axial_rate"][row])
    pairs.add("contact point", touch.point, run[f"{of}/contact_point"][row])
    k = state.bodies[wheel.disk, AXIS]
    pairs.add("slip", [touch.slip @ cross(k, UP), touch.slip @ k], run[f"{of}/slip_velocity"][row])
    assert abs(wheel.azimuth(state.bodies, state.mode.contacts[w])) < wheel.half_pitch + 1e-9, "the lowest roller"
    rollers, accelerations = state.bodies[wheel.rollers], state.reactions.acceleration[wheel.rollers]
    for name, theirs in (("position", rollers[:, POSITION]), ("velocity", rollers[:, VELOCITY]),
                         ("acceleration", accelerations[:, :3])):  # fmt: skip
        pairs.add(f"{name} of rollers", theirs, run[f"{of}/rollers/center_{name}"][row])


def add_joints(pairs, machine, run, state, w):
    """Force and moment of every axle on what it carries, along (h, k, n) or (d, a x d, a)."""
    wheel, row = machine.wheels[w], state.row
    of, turned = f"wheels/{wheel.name}", state.bodies[wheel.disk, ROTATION].reshape(3, 3)
    wrenches = zip(machine.child.tolist(), state.reactions.joints, strict=True)
    held = {body: (wrench[:3], wrench[3:]) for body, wrench in wrenches}
    d, a, k = wheel.d @ turned.T, wheel.a @ turned.T, state.bodies[wheel.disk, AXIS]
    frames, bodies = np.stack([d, cross(a, d), a], axis=1), range(wheel.rollers.start, wheel.rollers.stop)
    for part, name in enumerate(("force", "moment")):
        theirs = [frame @ held[body][part] for frame, body in zip(frames, bodies, strict=True)]
        pairs.add(f"{name} of roller axles", theirs, run[f"{of}/rollers/bearing_{name}"][row])
        if machine.chassis:
            theirs = np.array([cross(k, UP), k, UP]) @ held[wheel.disk][part]
            pairs.add(f"{name} of axles", theirs, run[f"{of}/bearing_{name}"][row])


@pytest.fixture(scope="module", params=SCENES)
def pairs(request):
    path, overrides, kind = SCENES[request.param]
    scene = omnisim.load(path, [*overrides, "output.bearing_loads=true"])
    run, pairs = omnisim.simulate(scene), Pairs()
    assert run.complete and "exchange" in run["events/kind"], run.attributes["status"]
    for machine, state in states(scene, run, kind, 6):
        add_body(pairs, machine, run, state)
        for w in range(len(machine.wheels)):
            add_wheel(pairs, machine, run, state, w)
            add_joints(pairs, machine, run, state, w)
    return pairs


def assert_equal(pairs, bounds):
    found = {name: pairs.difference(name) for name in bounds if name in pairs}
    assert found and all(found[name] < bounds[name] for name in found), found


def test_bodies_stand_and_move_where_joint_coordinates_put_them(pairs):
    names = ("position", "velocity", "axial rate", "contact point", "slip", "kinetic energy")
    assert_equal(pairs, dict.fromkeys((*names, "position of rollers", "velocity of rollers"), 1e-13))


def test_accelerations_are_those_of_the_free_bodies(pairs):
    names = ("acceleration", "yaw acceleration", "spin acceleration", "acceleration of rollers")
    assert_equal(pairs, dict.fromkeys(names, 1e-10))


def test_floor_and_servo_act_as_the_multipliers_say(pairs):
    assert_equal(pairs, dict.fromkeys(("normal force", "friction force", "servo torque"), 1e-11))


def test_axles_carry_the_multipliers_of_their_joints(pairs):
    names = (f"{name} of {axles}" for name in ("force", "moment") for axles in ("axles", "roller axles"))
    assert_equal(pairs, dict.fromkeys(names, 1e-11))
