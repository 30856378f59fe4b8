"""Scenes of machines free in space that are to break a simulation: uneven ground, falls, rubber hard or undamped.

All of them change bench/scenes/platform.toml, four mecanum wheels of 47.5 mm with rollers of 11.5 mm.
"""

from pathlib import Path

import numpy as np

from bench.hard_claims import Case, Comparison, converged, provided, worst
from omnisim.results.trajectory import Trajectory

PLATFORM = str(Path(__file__).parent / "scenes/platform.toml")
GRAVITY = 9.81
NAMES = ("fl", "fr", "rl", "rr")
LOCKED = "drive={kind='dc_motor', voltage=0.0, resistance=1.0, torque_constant=1e-9, rotor_inertia=1e12}"
HOLDING = 0.6 / np.sqrt(2.0)  # tan S* on which locked mecanum wheels hold, uphill ahead
EPS, RHO = 1e-6, 0.999  # slip_speed, m/s, and tan S / tan S*
KERB = 0.00575  # m, half a roller's radius
FALL, HALF_WIDTH = 0.3, 0.19  # m: height of a fall, and of the middle of a chassis on its side
SMALL = "chassis.size=[0.3, 0.1, 0.2]"  # a chassis that leaves room to tip


def drives(speed: float) -> tuple[str, ...]:
    """Overrides: it rolls at `speed` (m/s), and torques push it on."""
    spins = [f"wheels.{name}.spin_rate={speed / 0.0475!r}" for name in NAMES]
    return f"initial.velocity=[{speed!r}, 0.0]", *spins, *each("drive={kind='torque', torque=0.1}")


def each(setting: str) -> list[str]:
    """Overrides: the same for all wheels."""
    return [f"wheels.{name}.{setting}" for name in NAMES]


def two_in_the_air(run: Trajectory) -> bool:
    loads = np.column_stack([run[f"wheels/{wheel}/normal_force"] for wheel in run.wheels])
    return bool(np.any(np.sum(loads == 0.0, axis=1) == 2))


def all_up(run: Trajectory) -> bool:
    return bool(run["body/position"][-1, 2] > 0.9 * KERB)


def first_alone(run: Trajectory) -> bool:
    landings = run["events/time"][run["events/kind"] == "touch_down"]
    return bool(landings[1] > landings[0] + 1e-3)


def creeps(_case: Case, run: Trajectory) -> Comparison:
    """Locked mecanum wheels on a slope creep at sqrt 2 eps rho / sqrt(1 - rho^2)."""
    expected = np.sqrt(2.0) * EPS * RHO / np.sqrt(1.0 - RHO**2)
    way = run["body/position"][:, 0]
    found = -np.diff(way[len(way) // 2 :]) / np.diff(run.time)[0]
    return Comparison(
        worst(found, np.full(len(found), expected)) / expected, 1e-3, f"creep of {expected:.2g} m/s, relative"
    )


def falls_on_its_side(_case: Case, run: Trajectory) -> Comparison:
    """Nothing of it touches the floor until its chassis does, after sqrt(2 h / g)."""
    expected = np.sqrt(2.0 * (FALL - HALF_WIDTH) / GRAVITY)
    return Comparison(abs(run.attributes["stop_time"] - expected), 1e-12, "closed form of the time")


FINER, OTHER = converged(1e-6, "time.step=1e-5"), converged(1e-8, "solver.method=dopri5")
SPATIAL_CASES = (
    Case(
        "bump under a platform", "12 mm high: two wheels and four are in the air", PLATFORM,
        ("floor.bumps=[[0.45, 0.15, 0.012, 0.06]]", *drives(0.5)),
        provided(OTHER, two_in_the_air, "just two wheels in the air"), "rk4", 2e-5,
    ),
    Case(
        "kerb", "half as high as a roller is thick, with an edge of 3 mm", PLATFORM,
        (f"floor.steps=[{{point=[0.35, 0.0], direction_deg=0.0, height={KERB}, edge_radius=0.003}}]", *drives(0.3),
         "time.end=2.5"), provided(FINER, all_up, "all wheels get up"), "dopri5", 2e-5,
    ),
    Case(
        "pits", "narrower than a wheel", PLATFORM,
        ("floor.bumps=[[0.4, 0.15, -0.01, 0.045], [0.6, -0.15, -0.008, 0.045]]", *drives(0.5), "time.end=1.5"),
        FINER, "dopri5", 2e-5,
    ),
    Case(
        "ground of ridges", "its curvature jumps at each of 368 nodes", PLATFORM,
        ("floor.grid={file='jagged.csv', origin=[-0.4, -0.35], spacing=[0.07, 0.05]}", *drives(0.3)),
        FINER, "dopri5", 2e-5,
    ),
    Case(
        "landing on one wheel", "from 50 mm, aslant", PLATFORM, ("initial={height=0.07, roll_deg=6.0, pitch_deg=5.0}",),
        provided(converged(1e-6, "time.step=5e-6"), first_alone, "one wheel lands first"), "dopri5", 1e-5,
    ),
    Case(
        "no damping", "a machine that bounces for ever", PLATFORM,
        ("initial={height=0.02, roll_deg=2.0}", "wheel_types.mecanum.contact.damping=0.0"), OTHER, "rk4", 1e-5,
    ),
    Case(
        "stiffness 1e8 N/m", "rubber that is pressed in by half a micrometre", PLATFORM,
        ("initial={height=0.002}", "wheel_types.mecanum.contact={stiffness=1e8, damping=3000.0}", "time.end=0.2"),
        OTHER, "rk4", 1e-6,
    ),
    Case(
        "tilted by 30 deg", "wheels land on the ends of their rollers, two at one instant", PLATFORM,
        ("initial={height=0.1, roll_deg=30.0}",), converged(1e-6, "time.step=5e-6"), "dopri5", 1e-5,
    ),
    Case(
        "standing on a slope", "1000 s at 0.999 of what friction can hold, slip_speed 1e-6", PLATFORM,
        (f"floor.slope_deg={float(np.degrees(np.arctan(RHO * HOLDING)))!r}", f"friction.slip_speed={EPS!r}",
         *each(LOCKED), "time.end=1000.0", "time.output_interval=10.0"), creeps, "radau5", 1.0,
    ),
    Case(
        "tip-over", "until its chassis lies on the ground", PLATFORM,
        ("initial={height=0.16, roll_deg=50.0, roll_rate=3.0}", SMALL), OTHER, "rk4", 1e-5,
        stops="the chassis touches the ground",
    ),
    Case(
        "on its side", "no wheel touches anything", PLATFORM, (f"initial={{height={FALL}, roll_deg=90.0}}",),
        falls_on_its_side, "rk4", 1e-3, stops="the chassis touches the ground",
    ),
)  # fmt: skip
