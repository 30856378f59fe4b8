"""Scenes of machines free in space that are to break a simulation: uneven ground, falls, rubber hard or undamped.

All of them change bench/scenes/platform.toml, four mecanum wheels of 47.5 mm with rollers of 11.5 mm.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

import omnisim
from bench.hard_claims import Case, Comparison, converged, provided, worst
from omnisim.results.trajectory import Trajectory

PLATFORM = str(Path(__file__).parent / "scenes/platform.toml")
GRAVITY = 9.81
NAMES = ("fl", "fr", "rl", "rr")
LOCKED = "drive={kind='dc_motor', voltage=0.0, resistance=1.0, torque_constant=1e-9, rotor_inertia=1e12}"
FOLLOWING = "drive={kind='follow', times=[0.0, 2000.0], angle=[0.0, 0.0]}"  # no torque turns it
FRICTION = 0.6
HOLDING = FRICTION / np.sqrt(2.0)  # tan S* on which locked mecanum wheels hold, uphill ahead
RHO, ABOVE = 0.999, 1.001  # tan S / tan S*
EPS, FINE_EPS = 1e-6, 1e-9  # slip_speed, m/s
BRISTLES = 20.0  # creep_stiffness
COULOMB = f"friction={{law='coulomb', coefficient={FRICTION}}}"
BRUSH = f"friction={{law='brush', coefficient={FRICTION}, creep_stiffness={BRISTLES}, slip_speed={EPS!r}}}"
LONG_STAND = ("time.end=1000.0", "time.output_interval=10.0")
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


def on_slope(part: float) -> str:
    """Override: a slope of this part of tan S*."""
    return f"floor.slope_deg={float(np.degrees(np.arctan(part * HOLDING)))!r}"


def speed_down(run: Trajectory) -> np.ndarray:
    """Mean speed downhill between rows of the second half, where the rubber swings no more, m/s."""
    way = run["body/position"][len(run.time) // 2 :, 0]
    return -np.diff(way) / np.diff(run.time)[0]


def stands(_case: Case, run: Trajectory) -> Comparison:
    """Set-valued friction holds it: no creep at all."""
    moved = np.linalg.norm(run["body/position"] - run["body/position"][0], axis=1).max()
    return Comparison(float(moved) / run.time[-1], 1e-15, "rest: creep, m/s")


def creeps(law: str, expected: float) -> Callable[[Case, Trajectory], Comparison]:
    """Comparison: a smooth law has no force without slip, so what it holds creeps at a speed of the law's own, m/s.

    Only slip along their rollers' axes is resisted, sqrt 2 slower than the machine, which tilts by 2e-4: of tan S*
    that takes 1e-8, of the creep 6e-6.
    """

    def claim(_case: Case, run: Trajectory) -> Comparison:
        found = speed_down(run)
        error = worst(found, np.full(len(found), expected)) / expected
        return Comparison(error, 1e-3, f"creep of {expected:.2g} m/s, {law}, relative")

    return claim


def regularized_creep(slip_speed: float) -> float:
    """sqrt 2 eps rho / sqrt(1 - rho^2), m/s."""
    return float(np.sqrt(2.0) * slip_speed * RHO / np.sqrt(1.0 - RHO**2))


def brush_creep() -> float:
    """sqrt 2 eps q / sqrt(1 - q^2), q = 3 mu theta / c with 1 - (1 - theta)^3 = rho, m/s: the contact runs over its
    roller as fast as it slips."""
    part = 3.0 * FRICTION * (1.0 - np.cbrt(1.0 - RHO)) / BRISTLES
    return float(np.sqrt(2.0) * EPS * part / np.sqrt(1.0 - part**2))


def slides(case: Case, run: Trajectory) -> Comparison:
    """V = t g cos S (tan S - tan S*) M / (M + sum Ia / 2 r^2): rollers turn as they slide along their axes, r from
    their axes to the ground. Its tilt of 2e-4 takes 1.2e-8 of tan S*, which here is 1.2e-5 of V."""
    config = omnisim.load(case.scene, case.overrides).config
    (kind,), slope = config.wheel_types.values(), np.arctan(ABOVE * HOLDING)
    mass = config.chassis.mass + 4.0 * (kind.disk.mass + kind.roller_count * kind.roller.mass)
    sag = mass * GRAVITY * np.cos(slope) / 4.0 / kind.contact.stiffness
    rollers = 4.0 * kind.roller.inertia_axial / (2.0 * (kind.radius - kind.roller_distance - sag) ** 2)
    pull = GRAVITY * np.cos(slope) * (np.tan(slope) - HOLDING) * mass / (mass + rollers)
    middles = (run.time[1:] + run.time[:-1])[len(run.time) // 2 :] / 2.0
    return Comparison(
        float(np.abs(speed_down(run) / (pull * middles) - 1.0).max()), 1e-4, f"closed form, {pull:.2g} m/s^2, relative"
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
        "standing on a slope", "1000 s at 0.999 of what friction can hold, coulomb", PLATFORM,
        (on_slope(RHO), COULOMB, *each(FOLLOWING), *LONG_STAND), stands, "rk4", 5e-3,
    ),
    Case(
        "sliding down a slope", "1.001 of it: slip begins at 4e-3 m/s^2", PLATFORM,
        (on_slope(ABOVE), COULOMB, *each(FOLLOWING), "time.end=10.0", "time.output_interval=0.1"), slides, "rk4", 5e-3,
    ),
    Case(
        "creeping on a slope", "1000 s at 0.999 of it by a smooth law, slip_speed 1e-6", PLATFORM,
        (on_slope(RHO), f"friction.slip_speed={EPS!r}", *each(LOCKED), *LONG_STAND),
        creeps("regularized", regularized_creep(EPS)), "radau5", 1.0,
    ),
    Case(
        "creeping more slowly", "the same with slip_speed 1e-9, which relaxes slip at 1e12 1/s", PLATFORM,
        (on_slope(RHO), f"friction.slip_speed={FINE_EPS!r}", *each(FOLLOWING), *LONG_STAND),
        creeps("regularized", regularized_creep(FINE_EPS)), "radau5", 1.0,
    ),
    Case(
        "creeping on bristles", "1000 s at 0.999 of it, law brush, slip_speed 1e-6", PLATFORM,
        (on_slope(RHO), BRUSH, *each(FOLLOWING), *LONG_STAND), creeps("brush", brush_creep()), "radau5", 1.0,
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
