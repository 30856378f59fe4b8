"""Scenes with wheels on two rows of rollers that are to break a simulation: contacts that jump far along the axle."""

from pathlib import Path

from bench.hard_claims import FREE, STILL, Case, converged, provided, stays_on_the_edge, times_of
from omnisim.results.trajectory import Trajectory

LIFTING = str(Path(__file__).parent / "scenes/rows.toml")
# 0.2 m apart, four wheel radii
WIDE = ("wheel_types.omni.roller_count=3", "wheel_types.omni.rows=[{offset=-0.1}, {offset=0.1, phase_deg=60}]")


def hops(run: Trajectory) -> bool:
    """Whether wheels that have lifted come down again, five times or more."""
    return min(len(times_of(run, kind)) for kind in ("lift_off", "touch_down")) >= 5


ROW_CASES = (
    Case(
        "rows far apart", "the contact jumps by four wheel radii at every exchange", "six_rollers",
        ("friction.law=coulomb", *WIDE), converged(1e-9, "solver.method=radau5", "time.step=1e-4"), "rk4", 2e-4,
    ),
    Case(
        "500 rad/s on two rows", "the same every 2 ms, sliding", "six_rollers",
        ("friction.law=coulomb", "wheels.wheel.spin_rate=500", *WIDE), converged(2e-5, "time.step=1e-4"),
        "dopri5", 1e-3,
    ),
    Case(
        "at rest between rows", "a load shared over 0.2 m, and a yaw that goes on", "six_rollers",
        (FREE, *STILL, "wheels.wheel.spin_angle_deg=30", "wheels.wheel.roller_rates=0", *WIDE), stays_on_the_edge,
    ),
    Case(
        "lifted by its rows", "a wheel leaves the floor and lands as contacts of others jump", LIFTING, (),
        provided(converged(1e-8, "time.step=5e-5"), hops, "wheels lift and land"), "dopri5", 2e-4,
    ),
)  # fmt: skip
