"""Scenes that the engine and the oracle both move, in which every term of the equations of motion is at work."""

from pathlib import Path

REFERENCE = Path(__file__).parents[1] / "reference"
BASE = REFERENCE / "testbench_psi30.toml"
MOVING = (
    "initial.yaw_rate=1.1", "initial.yaw_deg=20.0", "wheels.wheel.spin_angle_deg=12.0",
    "wheels.wheel.roller_rates=[3.0, -2.0, 5.0, 1.0]", "time.output_interval=0.05", "time.step=1e-5",
)  # fmt: skip
PUSHED = (
    "wheels.wheel.drive={kind='torque', times=[0.0, 0.25, 0.25, 0.5], torque=[0.2, 0.6, -0.4, 0.1]}",
    "wrench.frame='body'", "wrench.times=[0.0, 0.31, 0.31]",
    "wrench.force=[[0.5, -1.0, 2.0], [1.0, 0.5, -4.0], [0.0, 0.7, 3.0]]", "wrench.yaw_torque=[0.02, -0.01, 0.03]",
)  # fmt: skip
# Two or three rows, some out of order, whose offsets do not balance.
ROWS = (
    "wheel_types.straight.roller_count=3",
    "wheel_types.straight.rows=[{offset=-0.012}, {offset=0.02, phase_deg=60.0}]",
    "wheels.front.roller_rates=[5.0, 2.0, -7.0, 2.0, 11.0, -3.0]",
    "wheel_types.tilted.roller_count=4",
    "wheel_types.tilted.rows=[{offset=0.02, phase_deg=30.0}, {offset=-0.015, phase_deg=345.0}]",
    "wheels.left.roller_rates=[-6.0, 14.0, 3.0, -2.0, 8.0, 1.0, 4.0, -9.0]",
    "wheel_types.crossed.roller_count=3",
    "wheel_types.crossed.rows=[{offset=-0.02}, {offset=0.025, phase_deg=80.0}, {offset=0.005, phase_deg=-80.0}]",
    "wheels.right.roller_rates=[9.0, -12.0, 4.0, 6.0, -5.0, 2.0, 7.0, 1.0, -8.0]",
)
BARE_ROWS = (
    "wheel_types.omni.roller_count=3",
    "wheel_types.omni.rows=[{offset=-0.02, phase_deg=-25.0}, {offset=0.05, phase_deg=35.0}]",
    "wheels.wheel.roller_rates=[3.0, -2.0, 5.0, 1.0, -6.0, 4.0]",
)
CASES = {
    f"psi {psi:g}": (f"wheel_types.omni.roller_angle_deg={psi!r}", "time.end=0.5") for psi in (0.0, 30.0, 45.0, -45.0)
}
CASES["mirrored, phase, driven and pushed"] = (
    "wheels.wheel.mirrored=true",
    "wheels.wheel.phase_deg=25.0",
    "time.end=0.5",
    *PUSHED,
)
CASES["saturated"] = ("friction.law=saturated", "time.end=0.25")
CASES["viscous"] = ("friction.law=viscous", "friction.viscosity=5.0", "time.end=0.5")
CASES["on a slope"] = ("floor={slope_deg=20.0, uphill_deg=-35.0}", "time.end=0.5", *PUSHED)
CASES["on two rows, pushed"] = (*BARE_ROWS, "time.end=0.5", *PUSHED)
CASES["brush"] = ("friction.law=brush", "friction.creep_stiffness=6.0", "time.end=0.5")
CASES["no friction"] = ("friction.law=none", "time.end=0.5")
SKEW, MECANUM = Path(__file__).parent / "skew.toml", REFERENCE / "mecanum.toml"
# rollers that spin, edges nearby, a yaw rate, and a slip speed that spares the oracle some of the stiffness
HEAVY = (
    "wheel_types.mecanum.roller.inertia_axial=1e-5", "friction.slip_speed=0.2", "friction.viscosity=20.0",
    "friction.creep_stiffness=6.0",
    "wheels.front_left.spin_angle_deg=25.0", "wheels.front_left.spin_rate=3.0",
    "wheels.front_right.phase_deg=-20.0", "wheels.front_right.spin_rate=-2.0",
    "wheels.rear_left.roller_rates=[9.0, -4.0, 2.0, -7.0, 1.0, 5.0]", "wheels.rear_left.heading_deg=4.0",
    "wheels.rear_right.position=[-0.21, -0.17]", "initial.yaw_deg=40.0", "initial.yaw_rate=-0.9",
    "wrench.frame='body'", "wrench.times=[0.0, 0.05, 0.05]",
    "wrench.force=[[5.0, -9.0, 3.0], [8.0, 2.0, -6.0], [0.0, 4.0, 9.0]]", "wrench.yaw_torque=[0.5, -1.0, 0.7]",
    "time.end=0.12", "time.step=1e-5", "time.output_interval=0.02",
)  # fmt: skip


def following(*wheels):
    """Overrides by which these wheels follow angles: forward and back by an edge or more."""
    times, angles = [0.0, 0.03, 0.05, 0.09, 0.12, 0.15], [0.0, 0.3, 0.2, -0.4, -0.1, 0.5]
    overrides = []
    for number, wheel in enumerate(wheels):
        turned = [(1.0 + 0.3 * number) * angle for angle in angles]
        overrides.append(f"wheels.{wheel}.drive={{kind='follow', times={times}, angle={turned}}}")
        overrides += [f"wheels.{wheel}.spin_angle_deg=0.0", f"wheels.{wheel}.spin_rate={4.0 - number}"]
    return tuple(overrides)


def resisting(*types):
    """Overrides by which rollers of these types resist rolling, each by its own length."""
    return tuple(
        f"wheel_types.{name}.roller.{key}"
        for number, name in enumerate(types)
        for key in (f"rolling_resistance={2e-3 * (1 + number)}", f"rolling_rate={2.0 + number}")
    )


LAWS = ("regularized", "saturated", "viscous", "brush", "none")
MACHINES = {"three skew wheels": (SKEW, ()), "the same with a servo": (SKEW, ("scene.upright=servo",))}
MACHINES["four mecanum wheels"] = (MECANUM, HEAVY)
MACHINES["three skew wheels on rows"] = (SKEW, ROWS)
MACHINES["three skew wheels on a slope"] = (SKEW, ("floor={slope_deg=8.0, uphill_deg=110.0}",))
