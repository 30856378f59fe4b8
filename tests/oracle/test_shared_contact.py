"""Rest on two rollers against an oracle that knows neither rest nor exchanges, only a load that moves smoothly.

For a smooth law of friction the swings about an edge die out exponentially, ever faster to and fro, and never end:
`share_begin` is when the engine stops following them. In the oracle they are smaller than delta from rest.begin on.
"""

import tomllib
from math import cos, inf, pi, radians, sin

import numpy as np
import pytest
from scenes import REFERENCE, reference_data

import omnisim
from omnisim.scene.scene import load
from oracle.scenes import resisting
from oracle.shared_contact import limit, simulate
from oracle.states import OnTwo, states
from oracle.vectors import AXIS

BASE = REFERENCE / "testbench_psi30.toml"
RATIO = 10.0
# SI units. Measured against the engine at step 1e-4: position 8e-10, yaw 2e-8, spin angle 4e-9
ANYWHERE = {"position": 1e-8, "yaw": 1e-7, "spin_angle": 2e-8}
# where swings are over: 6e-10, 6e-8, 2e-8, 2e-7, share 8e-6 (what is left of the swings in the oracle)
SETTLED = {"velocity": 1e-8, "yaw_rate": 3e-7, "spin_rate": 1e-7, "roller_axial_rate": 1e-6, "share": 5e-5}
SETTLING = 0.1  # after share_begin [s]


def coasting(row: int, end: float) -> tuple[str, ...]:
    """The reference wheel from one of its rows on. From the last, t = 6 s, it soon rests on two rollers, for long."""
    data = reference_data("testbench_psi30")
    position, velocity, rates = (data[key][row] for key in ("position", "velocity", "roller_axial_rate"))
    yaw, yaw_rate, spin, spin_rate = (float(data[key][row]) for key in ("yaw", "yaw_rate", "spin_angle", "spin_rate"))
    psi, azimuth = radians(30.0), pi / 2.0 * np.arange(4) - spin
    relative = rates - spin_rate * sin(psi) + yaw_rate * cos(psi) * np.sin(azimuth)
    return (
        f"initial.position={position.tolist()}", f"initial.velocity={velocity.tolist()}",
        f"initial.yaw_deg={float(np.degrees(yaw))!r}", f"initial.yaw_rate={yaw_rate!r}",
        f"wheels.wheel.spin_angle_deg={float(np.degrees(spin))!r}", f"wheels.wheel.spin_rate={spin_rate!r}",
        f"wheels.wheel.roller_rates={relative.tolist()}",
        f"time.end={end!r}", "time.output_interval=0.1", "time.step=1e-4",
    )  # fmt: skip


# rest from 0.3 s until one roller has no load left at 0.633 s
VISCOUS = (
    "friction.law=viscous", "friction.viscosity=100.0", "wheel_types.omni.roller_count=6",
    "wheel_types.omni.roller_angle_deg=45.0", "wheel_types.omni.roller_distance=0.05",
    "wheel_types.omni.disk={mass=1.0, inertia_axle=0.002, inertia_diameter=0.0015}",
    "wheels.wheel.spin_angle_deg=29.1", "wheels.wheel.spin_rate=0.8",
    "wheels.wheel.roller_rates=[1.0, -5.0, -4.0, 13.0, -31.0, 35.0]",
    "initial.position=[0.0, 0.0]", "initial.velocity=[0.0, 0.1]", "initial.yaw_rate=2.0",
    "time.end=1.0", "time.output_interval=0.05", "time.step=1e-4",
)  # fmt: skip
# two rows aside of each other, with the rollers of VISCOUS
ROWS = ("wheel_types.omni.roller_count=3", "wheel_types.omni.rows=[{offset=-0.03}, {offset=0.03, phase_deg=60.0}]")
# overrides, the finest delta, and whether one share reaches zero before the end
CASES = {"regularized": (coasting(-1, 2.0), 1e-8, False), "viscous": (VISCOUS, 1e-9, True)}
CASES["viscous, on two rows"] = ((*VISCOUS, *ROWS), 1e-9, False)


def test_the_oracle_reproduces_exchanges_without_rest():
    """From t = 5 s to 6 s, twice over an edge. Where no wheel rests the error goes as delta squared."""
    rows = {key: value[50:61] for key, value in reference_data("testbench_psi30").items() if np.ndim(value)}
    scene = load(BASE, coasting(50, 1.0))
    motion = simulate(tomllib.loads(scene.text), (rows["time"] - rows["time"][0]).tolist(), 1e-6, rtol=1e-12)
    assert not motion.rests
    for name in ("position", "yaw", "spin_angle", "velocity", "yaw_rate", "spin_rate"):
        assert np.abs(getattr(motion, name) - rows[name]).max() < 1e-9, name  # measured 8e-11


# standing on an edge, twisted: each roller alone would roll the wheel onto the other
TWISTED = (
    "initial={velocity=[0.0, 0.0], yaw_rate=0.0}", "wheels.wheel.spin_rate=0.0", "wheels.wheel.spin_angle_deg=45",
    "wrench={times=[0.0, 0.2], force=[[0.0, 0.5, 1.0], [0.0, 0.2, -3.0]], yaw_torque=[0.3, 0.4]}",
    "time={end=0.2, step=1e-4, output_interval=0.01}",
)  # fmt: skip


ON_ROWS = (*TWISTED, *ROWS, "wheels.wheel.spin_angle_deg=30")
TOGETHER = [TWISTED, (*TWISTED, "friction.law=saturated"), VISCOUS, ON_ROWS, (*VISCOUS, *ROWS)]
TOGETHER += [(*TWISTED, *resisting("omni")), (*ON_ROWS, *resisting("omni"))]


@pytest.mark.parametrize("overrides", TOGETHER, ids=range(len(TOGETHER)))
def test_shares_of_the_load_on_two_rollers_keep_a_wheel_at_rest(overrides):
    """With the shares of the run both rollers together leave a wheel of free bodies where it is."""
    scene = load(BASE, overrides)
    run, at, compared = omnisim.simulate(scene), "wheels/wheel", 0
    for _, state in states(scene, run, OnTwo, 20):
        share, row, told = run[f"{at}/contact_share"][state.row], state.row, state.told
        if share == 1.0:
            continue
        carried, acceleration = state.reactions.normal_force, state.reactions.acceleration
        assert abs(acceleration[0, 3:] @ state.bodies[0, AXIS]) < 1e-9  # rad/s^2; it does not spin
        assert abs(carried.sum() - run[f"{at}/normal_force"][row]) < 1e-11  # N
        assert abs(told["servo_torque"] - run[f"{at}/servo_torque"][row]) < 1e-11  # N m
        assert np.abs(told["acceleration"] - run["body/acceleration"][row, :2]).max() < 1e-10
        assert abs(told["yaw_acceleration"] - run["body/yaw_acceleration"][row]) < 1e-9
        compared += 0.0 < share < 1.0
    assert compared > 5


def aitken(values: list[float]) -> float:
    """Limit of three members of a geometric sequence."""
    first, second = values[1] - values[0], values[2] - values[1]
    return values[2] + second**2 / (first - second)


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_the_engine_rests_on_two_rollers_as_the_limit_of_a_smooth_hand_over_does(case):
    overrides, delta, leaves = CASES[case]
    scene = load(BASE, overrides)
    run = omnisim.simulate(scene)
    assert run.complete, run.attributes["status"]
    kinds, times = np.array(run["events/kind"], dtype=str), run["events/time"]
    begins, ends = times[kinds == "share_begin"], times[kinds == "share_end"]

    described, outputs = tomllib.loads(scene.text), run.time.tolist()
    motions = [simulate(described, outputs, RATIO**power * delta, rtol=1e-10) for power in (2, 1, 0)]
    rests = [rest for motion in motions for rest in motion.rests]
    assert len(rests) == len(motions)
    oracle = limit(*motions[1:], RATIO)

    # the engine follows the swings to below delta, and not for more than four further decades
    assert len(begins) == 1
    decade = rests[2].begin - rests[1].begin
    assert rests[2].begin < begins[0] < rests[2].begin + 4.0 * decade
    if leaves:
        assert len(ends) == 1
        assert abs(ends[0] - aitken([rest.end for rest in rests])) < 1e-4  # measured 2e-5
    else:
        assert len(ends) == 0 and rests[2].end == inf

    ours = {
        "position": run["body/position"][:, :2],
        "velocity": run["body/velocity"][:, :2],
        "yaw": run["body/yaw"],
        "yaw_rate": run["body/yaw_rate"],
        "spin_angle": run["wheels/wheel/spin_angle"],
        "spin_rate": run["wheels/wheel/spin_rate"],
        "roller_axial_rate": run["wheels/wheel/rollers/axial_rate"],
        "share": run["wheels/wheel/contact_share"],
    }
    settled = run.time > begins[0] + SETTLING
    shared = settled & (run.time < (ends[0] if leaves else inf))
    assert np.abs(ours["spin_angle"][shared] - rests[2].edge).max() < 1e-12
    assert not ours["spin_rate"][shared].any()
    worst = {name: np.abs(ours[name] - oracle[name]).max() for name in ANYWHERE}
    for name in SETTLED:
        rows = shared if name == "share" else settled
        worst[name] = np.abs(ours[name][rows] - oracle[name][rows]).max()
    assert all(worst[name] < bound for name, bound in (ANYWHERE | SETTLED).items()), worst
