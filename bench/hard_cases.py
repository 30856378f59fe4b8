"""Scenes chosen to break a simulation, each with a claim about its motion: what tests/laws/test_hard_cases.py asserts.

A claim compares with a closed form where there is one, else with another method or a finer step. Whatever the claim,
the energy of every case is balanced and friction never does positive work.
"""

from pathlib import Path

import numpy as np

from bench.common import Claim, table
from bench.hard_claims import (
    BRAKE,
    FREE,
    JUMPS,
    LIGHT,
    PULL,
    ROCK,
    SHAKE,
    SPIN,
    SPUN_ANGLE,
    STILL,
    SWING,
    SWINGS,
    TORQUES,
    WHEEL,
    Case,
    accelerates,
    coasts_on_two_rollers,
    converged,
    exchanges_on_rows,
    first_order,
    friction_power,
    lifts_off,
    names_the_step,
    rocks_by_table,
    rolls_for_ever,
    rolls_under_the_table,
    slides_freely,
    slip_reverses,
    spin_up,
    stays_on_the_edge,
    steps_of,
    sticks_on_the_edge,
    swings,
    torque,
    turns_on_the_edge,
    wrench,
)
from bench.hard_rows import ROW_CASES
from bench.hard_slip import NEAR_LIMIT, SLIP_CASES, opposed
from bench.hard_spatial import SPATIAL_CASES
from omnisim.results.comparison import energy_error

PSI30 = str(Path(__file__).parents[1] / "tests/reference/testbench_psi30.toml")
BALANCED = 1e-9  # |energy/balance| in the energy of the scene, at most
VISCOUS = ("friction.law=viscous", "friction.viscosity=8.5e5")
NOTES = """Errors are the largest in any row, of position (m), yaw and spin angle (rad) against another run, or of what
has the closed form (m/s, rad/s, s). Energy: the largest imbalance, relative to the initial kinetic energy, or else to
the energy turned over. Time: the march of this run alone."""

# A wheel at rest on an edge, whose rollers both push it back once friction has settled, within nanoseconds.
PRESSED = (
    *STILL, "initial.yaw_rate=0", "wheels.wheel.spin_angle_deg=20", torque(-7.309445854288337e-4),
    "wrench={times=[0.0], yaw_torque=[0.12354274284669106]}", "time.end=0.1", "time.output_interval=0.01",
    "friction.coefficient=0.5637859789438575", "friction.slip_speed=1e-6",
    "wheel_types.omni={radius=0.1, roller_distance=0.08597782768422262, roller_count=9, roller_angle_deg=45.0, "
    "disk={mass=0.9, inertia_axle=0.0028, inertia_diameter=0.0026}, "
    "roller={mass=0.1, inertia_axial=7.343212068562253e-06, inertia_transverse=8e-5}}",
)  # fmt: skip


CASES = (
    Case(
        "light rollers", "roller inertia 1e-9 kg m^2", "coulomb_wheel", (LIGHT,),
        converged(1e-10, "solver.method=radau5", "time.step=2.5e-4"),
    ),
    Case(
        "light roller spun up", "slip that lasts a microsecond in a step of 1 ms", "coulomb_wheel",
        (LIGHT, "initial.velocity=[0, 0.3]", "wheels.wheel.spin_rate=0"), spin_up,
    ),
    Case(
        "slip_speed 1e-7", "a law that is nearly a jump", "coulomb_wheel",
        ("friction.law=regularized", "friction.slip_speed=1e-7"), first_order, "radau5",
    ),
    Case(
        "coasting on two rollers", "ever shorter swings about an edge, then a load shared for 50 s", PSI30,
        ("time.end=60",), coasts_on_two_rollers, "radau5", 2e-4,
    ),
    Case(
        "rocking on its own", "a thousand exchanges on one edge", "six_rollers",
        (FREE, "wheels.wheel.roller_rates=[4000, 0, 0, 0, 0, 0]", "wheels.wheel.spin_angle_deg=90",
         "wheels.wheel.spin_rate=2", "initial.yaw_rate=12", "time.end=160"), swings, "dopri5", 5e-4,
    ),
    Case(
        "rocking by torque", "999 torque jumps, each exactly at an exchange", "coulomb_wheel",
        (f"wheels.wheel.spin_rate={ROCK!r}", f"initial.velocity=[{WHEEL.radius * ROCK!r}, 0]",
         "wheels.wheel.spin_angle_deg=22.5", f"time.end={SWINGS * SWING - 0.02!r}",
         steps_of([-SHAKE, SHAKE] * (SWINGS // 2), [SWING * i for i in range(1, SWINGS)])), rocks_by_table,
    ),
    Case(
        "turning on an edge", "the spin ends on the edge: exchange or none", "six_rollers",
        (FREE, "wheels.wheel.spin_angle_deg=0", f"wheels.wheel.spin_rate={SPIN!r}", torque(-BRAKE),
         "initial.yaw_rate=0", "wheels.wheel.roller_rates=0"), turns_on_the_edge,
    ),
    Case(
        "at rest on an edge", "the spin must not start in either sense", "six_rollers",
        (FREE, *STILL, "wheels.wheel.spin_angle_deg=30", "wheels.wheel.roller_rates=0"), stays_on_the_edge,
    ),
    Case(
        "500 rad/s, no friction", "five exchanges in a step, spinning rollers, yaw", "six_rollers",
        (FREE, "wheels.wheel.spin_rate=500", "initial.yaw_rate=5"), converged(1e-5, "time.step=2e-4"), "dopri5", 1e-2,
    ),
    Case(
        "500 rad/s, sliding", "an exchange every 2 ms for 2 s", "six_rollers",
        ("friction.law=coulomb", "wheels.wheel.spin_rate=500"), converged(2e-5, "time.step=1e-4"), "dopri5", 1e-3,
    ),
    Case(
        "psi = 80 deg", "the contact point jumps by 0.8 m, eight wheel radii", PSI30,
        ("wheel_types.omni.roller_angle_deg=80",), converged(1e-8, "time.step=2.5e-5"), "radau5", 1e-4,
    ),
    Case(
        "three rollers", "contact radius from 30 mm to 10 mm over 120 deg", "six_rollers",
        ("wheel_types.omni.roller_count=3", "wheel_types.omni.roller_distance=0.02",
         "wheel_types.omni.roller_angle_deg=20", "wheels.wheel.roller_rates=3"),
        converged(1e-10, "time.step=2.5e-5"), "radau5", 1e-4,
    ),
    Case(
        "two hundred rollers", "stop and release in every 1.8 deg", "coulomb_wheel",
        ("wheel_types.omni.roller_count=200",), converged(1e-10, "solver.method=radau5", "time.step=2.5e-4"),
    ),
    Case(
        "pointed tips", "a contact radius of 0: no spin is fast enough to roll", "six_rollers",
        ("wheel_types.omni.roller_distance=0.04330127018922193", "wheel_types.omni.roller_angle_deg=30",
         "friction.law=coulomb"), converged(1e-8, "time.step=2.5e-5"), "radau5", 1e-4,
    ),
    Case(
        "stuck for 1e5 s", "drift of the slip over 127324 exchanges", "coulomb_wheel",
        ("initial.velocity=[0.05, 0]", "wheels.wheel.spin_rate=1", torque(0.01), wrench((-0.2, 0, 0)), "time.end=1e5",
         "time.output_interval=1000"), rolls_for_ever, "rk4", 0.1,
    ),
    Case(
        "rest below the limit", "0.999999 of what friction can hold", "coulomb_wheel", opposed(0.999999),
        accelerates(0.0), "rk4", 1e-2,
    ),
    Case(
        "rest above the limit", "1.000001 of it: slip at 1e-5 m/s", "coulomb_wheel", opposed(1.000001),
        accelerates(1e-6 * WHEEL.limit), "auto", 1e-2,
    ),
    Case(
        "torque jumps", "fifty jumps inside steps", "coulomb_wheel",
        ("initial.velocity=[0.5, 0]", steps_of([*TORQUES.tolist()], JUMPS[1:-1].tolist())), rolls_under_the_table,
        "rk4", 1e-2,
    ),
    Case(
        "slip reversal", "slip passes zero with the force outside the cone", "coulomb_wheel",
        ("initial.velocity=[0.5, 0]", "wheels.wheel.spin_rate=0", torque(PULL), "time.end=0.1"), slip_reverses,
    ),
    Case("no friction", "mu = 0", "coulomb_wheel", ("friction.coefficient=0", torque(0.01)), slides_freely),
    Case("no load", "N = 0: no force, no lift-off", "coulomb_wheel", (wrench((0, 0, WHEEL.weight)),), slides_freely),
    Case(
        "load touches zero", "N = 0 for one instant", "coulomb_wheel",
        (wrench((0, 0, 0), (0, 0, WHEEL.weight), (0, 0, 0), times=(0.0, 1.0, 2.0)),),
        converged(1e-8, "solver.method=radau5", "time.step=2e-4"),
    ),
    Case(
        "negative load", "the wheel leaves the floor", "coulomb_wheel",
        (wrench((0, 0, 0), (0, 0, 3 * WHEEL.weight), times=(0.0, 1.0)),), lifts_off, stops="leaves the floor",
    ),
    Case(
        "stop on an edge", "stick and exchange at one instant", "coulomb_wheel",
        ("initial.velocity=[0, 0]", "wheels.wheel.spin_rate=30",
         f"wheels.wheel.spin_angle_deg={float(np.degrees(WHEEL.alpha - SPUN_ANGLE))!r}"), sticks_on_the_edge,
    ),
    Case(
        "exchange on every row", "events on output times, at the start and on the last step", "coulomb_wheel",
        (f"wheels.wheel.spin_rate={2 * WHEEL.alpha / 0.1!r}",
         f"initial.velocity=[{2 * WHEEL.alpha / 0.1 * WHEEL.radius!r}, 0]", "wheels.wheel.spin_angle_deg=-22.5",
         "time.output_interval=0.1"), exchanges_on_rows, "rk4", 1e-2,
    ),
    Case(
        "authors' viscosity", "8.5e5 N s/m: slip relaxes at 3e6 1/s", "authors_sliding",
        (*VISCOUS, "initial.velocity=[1.5707963267948966, 0]", "initial.yaw_rate=0", wrench((0, 0.05, 0))),
        converged(1e-8, "time.step=1e-4"), "radau5", 1e-2,
    ),
    Case(
        "authors' viscosity, thrown", "0.6 m/s of slip gone in a microsecond", "authors_sliding", VISCOUS,
        converged(1e-8, "time.step=1e-4"), "radau5", 1e-2,
    ),
    Case(
        "near the limit", "releases and slow slip at every exchange", NEAR_LIMIT, (),
        converged(1e-8, "time.step=2.5e-5"), "radau5", 1e-4,
    ),
    Case(
        "near the limit, regularized", "the same by a smooth law, slip_speed 1e-7", NEAR_LIMIT,
        ("friction.law=regularized", "friction.slip_speed=1e-7"), converged(1e-5, "friction.law=coulomb"),
        "radau5", 1e-4,
    ),
    Case(
        "between two rollers, regularized", "rocks on an edge within nanoseconds, slip_speed 1e-6", PSI30,
        (*PRESSED, "friction.law=regularized"),
        converged(1e-5, "friction.law=coulomb"), "radau5",
    ),
    Case(
        "between two rollers, saturated", "the same by a law with a kink", PSI30,
        (*PRESSED, "friction.law=saturated"),
        converged(1e-5, "friction.law=coulomb"), "radau5",
    ),
    Case(
        "too stiff for rk4", "relaxes 3000 times in a step", "authors_sliding",
        (*VISCOUS, "time.end=0.01", "time.output_interval=0.01"), names_the_step, stops="use time.step <",
    ),
    *SLIP_CASES,
    *ROW_CASES,
    *SPATIAL_CASES,
)  # fmt: skip


def measure(_rounds: int = 1) -> list[dict[str, object]]:
    """The rows of the table."""
    return [row(case) for case in CASES]


def row(case: Case) -> dict[str, object]:
    """Run a case: its claim, what is claimed of all, and the seconds that the march took."""
    run = case.run()
    error, bound, against = case.claim(case, run)
    return {
        "scene": case.name,
        "hard": case.hard,
        "method": case.method,
        "step": case.step,
        "error": error,
        "bound": bound,
        "against": against,
        "status": run.attributes["status"],
        "energy": energy_error(run).relative,
        "friction_power": friction_power(run),
        "time": run.attributes["wall_time"],
    }


def report(rows: list[dict[str, object]]) -> str:
    header = ["scene", "what is hard", "method", "step, s", "error", "against", "energy", "time, s"]
    lines = [
        [*(row[key] for key in ("scene", "hard", "method")), f"{row['step']:g}", f"{row['error']:.1e}", row["against"],
         f"{row['energy']:.0e}{'' if row['energy'] < BALANCED else ', missed'}", f"{row['time']:.2f}"]
        for row in rows
    ]  # fmt: skip
    refusals = [f"- {row['scene']}: {row['status']}" for row in rows if row["status"] != "complete"]
    return "\n\n".join([table(header, lines), NOTES, "Runs that stop, and say so:", "\n".join(refusals)])


def claims(rows: list[dict[str, object]]) -> list[Claim]:
    kept = sum(row["error"] < row["bound"] and row["energy"] < BALANCED for row in rows)
    return [Claim("hard cases that keep their bounds and their energy", kept, "at least", len(rows), len(rows))]
