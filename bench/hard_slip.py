"""Scenes whose slip is to break a simulation: it all but stops, turns round, creeps, or ends at many wheels at once."""

from pathlib import Path

import numpy as np

import omnisim
from bench.hard_claims import (
    STILL,
    WHEEL,
    Case,
    Comparison,
    accelerates,
    converged,
    provided,
    steps_of,
    times_of,
    torque,
    wrench,
)
from omnisim.results.trajectory import Trajectory

NEAR_LIMIT = str(Path(__file__).parent / "scenes/near_limit.toml")
KIWI = str(Path(__file__).parent / "scenes/kiwi_spun.toml")
ROWS = "wheel_types.omni.rows=[{offset=-0.01}, {offset=0.01, phase_deg=22.5}]"
HELD, PUSH, PULSE = 0.99, 1.5, 1e-4  # of what friction can hold: torque, and in pulses; s of a pulse
PULSES = [0.0123 + 0.05 * i for i in range(20)]  # s, when they begin, inside steps


def opposed(share: float) -> tuple[str, ...]:
    """A wheel at rest under a torque and a force that friction holds together up to share = 1 of its limit."""
    force = share * WHEEL.limit
    return *STILL, torque(force * WHEEL.radius), wrench((-force, 0, 0))


def nudged() -> tuple[str, ...]:
    """A wheel at rest, nearly let go, which short pulses of torque let go."""
    turning = WHEEL.limit * WHEEL.radius
    jumps = [time for begin in PULSES for time in (begin, begin + PULSE)]
    torques = [HELD * turning, PUSH * turning] * len(PULSES) + [HELD * turning]
    return *STILL, wrench((-HELD * WHEEL.limit, 0, 0)), steps_of(torques, jumps)


def lets_go_by_each(run: Trajectory) -> bool:
    """Whether each pulse makes it slip, and it holds again before the next."""
    return all(len(times_of(run, kind)) == len(PULSES) for kind in ("slip", "stick"))


def stops_in_time(run: Trajectory) -> bool:
    """Whether slip first ends after r w / (mu N (3 r^2 / I + R^2 / J)), r from the middle to a wheel, w the yaw rate.

    Rollers turn freely about their axes, so they do not count there in I; that one touches takes 1e-7 of it.
    """
    config = omnisim.load(KIWI).config
    assert config.chassis is not None
    kind, count = config.wheel_types["omni"], len(config.wheels)
    roller, arm = kind.roller, float(np.hypot(*config.wheels[0].position))
    mass = kind.disk.mass + kind.roller_count * roller.mass
    ring = kind.roller_count * (roller.mass * kind.roller_distance**2 + roller.inertia_transverse)
    inertia = config.chassis.inertia[2] + count * (mass * arm**2 + kind.disk.inertia_diameter + ring / 2)
    friction = config.friction.coefficient * (config.chassis.mass / count + mass) * config.world.gravity
    slowing = friction * (count * arm**2 / inertia + kind.radius**2 / (kind.disk.inertia_axle + ring))
    return bool(abs(times_of(run, "stick")[0] * slowing / (arm * config.initial.yaw_rate) - 1.0) < 1e-6)  # 1.2e-7


def stop_together(_case: Case, run: Trajectory) -> Comparison:
    """Three wheels in the same pose about the machine's middle come to roll at the same instants; it stays in place."""
    times = times_of(run, "stick")
    again = len(times) > 3 and len(times) % 3 == 0
    spread = np.ptp(times.reshape(-1, 3), axis=1).max() if again else np.inf
    return Comparison(float(max(spread, np.abs(run["body/position"]).max())), 1e-11, "symmetry")


SLIP_CASES = (
    Case(
        "passing by rest", "slip all but stops, and turns round in 1e-5 s", "coulomb_wheel",
        (*STILL, "wheel_types.omni.roller_angle_deg=45", torque(0.0, 0.25, times=(0.0, 1.0)), "time.end=0.9"),
        converged(1e-7, "solver.method=radau5", "time.step=1e-4"), "dopri5", 5e-4,
    ),
    Case(
        "nudged", "let go for 0.1 ms, inside a step of 10 ms, 20 times", "coulomb_wheel", nudged(),
        provided(converged(1e-10, "solver.method=radau5", "time.step=1e-3"), lets_go_by_each, "20 slips and stops"),
        "rk4", 1e-2,
    ),
    Case(
        "rest at the limit", "just what friction can hold", "coulomb_wheel", opposed(1.0), accelerates(0.0),
        "rk4", 1e-2,
    ),
    Case(
        "slip of 1e-12 m/s", "it turns by 90 deg as it grows, 1.000001 of what friction can hold", "coulomb_wheel",
        (*opposed(1.000001), "initial.velocity=[0, 1e-12]"), accelerates(1e-6 * WHEEL.limit), "rk4", 1e-2,
    ),
    Case(
        "near the limit, every body", "slow slip that turns, in the multibody formulation", NEAR_LIMIT,
        ("solver.formulation=multibody",),
        converged(1e-7, "solver.method=radau5", "solver.formulation=reduced", "time.step=1e-4"), "dopri5", 5e-4,
    ),
    Case(
        "near the limit, two rows", "the same, its contact jumping from row to row", NEAR_LIMIT, (ROWS,),
        converged(1e-7, "solver.method=radau5", "time.step=1e-4"), "dopri5", 5e-4,
    ),
    Case(
        "three stops at once", "all wheels come to roll at one instant, after each exchange too", KIWI, (),
        provided(stop_together, stops_in_time, "the first by its closed form to 1e-6"), "rk4", 1e-2,
    ),
    Case(
        "thrown and spun", "the slip of four wheels turns, stops and begins again at exchanges", "youbot",
        ("initial.velocity=[0.5, 0.3]", "initial.yaw_rate=5", "time.end=1"),
        converged(1e-6, "solver.method=radau5", "time.step=1e-4"), "dopri5", 5e-4,
    ),
)  # fmt: skip
