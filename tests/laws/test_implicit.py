"""The implicit method: order, stiff scenes that explicit steps cannot follow, and the way from smooth to Coulomb."""

import numpy as np
import pytest
from helpers.stages import either
from scenes import final_state, packed, reference_data, reference_scene

import omnisim
from omnisim.base.methods import RADAU, collocation
from omnisim.march.stiffness import explanation
from omnisim.results.comparison import distance

LIGHT = "wheel_types.omni.roller={mass=0.02, inertia_axial=1e-9, inertia_transverse=2.3e-6}"
# Wheels whose friction lets go, slips slowly and reverses, driven and free; bounds: slope of the error in slip_speed
SCENES = {
    "free": ("wheels.wheel.spin_rate=-10", "initial.yaw_rate=1.0"),
    "driven beyond its limit and back": (
        "wheels.wheel.drive={kind='torque', times=[0.0, 0.5, 1.5], torque=[0.0, 0.17, 0.15]}", "initial.yaw_rate=2.0",
    ),
    "driven to and fro": (
        "wheels.wheel.drive={kind='torque', times=[0.0, 0.4, 0.4, 1.5], torque=[0.3, 0.3, -0.3, -0.3]}",
        "initial.yaw_rate=-1.0", "wheel_types.omni.roller_angle_deg=30",
    ),
}  # fmt: skip
SPAN = ("time.end=1.5", "time.output_interval=1.5")


def run(name, *overrides):
    trajectory = omnisim.simulate(reference_scene(name, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


@pytest.mark.short
def test_radau_iia_is_collocation_of_order_five():
    """Collocation of order 3 by construction; the quadrature of its last stage has order 5, and R is stiffly damped."""
    a = collocation(RADAU.c)
    for k in range(1, 6):
        assert abs(a[-1] @ RADAU.c ** (k - 1) - 1.0 / k) < 1e-15
    for z in (-1e3, -1e9):
        last = np.linalg.solve(np.eye(3) - z * a, np.ones(3))[-1]
        assert abs(last) < 4.0 / abs(z)  # |R(z)| -> 0: L-stable
    vectors = np.column_stack([RADAU.real_right, RADAU.complex_right, RADAU.complex_right.conj()])
    rows = np.vstack([RADAU.real_left, RADAU.complex_left, RADAU.complex_left.conj()])
    values = np.diag([RADAU.real_value, RADAU.complex_value, np.conj(RADAU.complex_value)])
    assert np.abs(vectors @ values @ rows - np.linalg.inv(a)).max() < 1e-13
    assert np.abs(rows @ vectors - np.eye(3)).max() < 1e-14


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("testbench_psi30", ()),
        ("testbench_psi0", ("wheels.wheel.drive={kind='torque', times=[0.0, 0.3, 0.3], torque=[0.0, 0.3, -0.2]}",)),
        ("testbench_psi30", ("solver.tracking=implicit",)),
    ],
)
def test_it_converges_at_order_five_through_exchanges(name, overrides):
    """With friction so faint that no step is parted for its sake."""
    law = ("friction.law=viscous", "friction.viscosity=0.5", "solver.method=radau5")
    span = ("time.end=1.0", "time.output_interval=1.0", *law, *overrides)
    finest = final_state(run(name, *span, "time.step=1.25e-4"))
    errors = [np.abs(final_state(run(name, *span, f"time.step={h}")) - finest).max() for h in (5e-3, 6.25e-4)]
    assert np.log2(errors[0] / errors[1]) / 3.0 > 4.4, errors  # measured 4.79, 4.54, 4.79


@pytest.mark.parametrize("method", ["radau5", "auto"])
@pytest.mark.parametrize("name", ["testbench_psi0", "testbench_psi30"])
def test_it_reaches_the_reference_cases(name, method):
    trajectory, reference = run(name, f"solver.method={method}", "time.step=1e-4"), reference_data(name)
    error = np.abs(trajectory["body/position"][:, :2] - reference["position"]).max()
    assert error < 1e-8  # measured: radau5 3e-12, auto (rk4 here) 4.2e-9
    assert np.abs(trajectory["body/yaw"] - reference["yaw"]).max() < 1e-8


def test_the_authors_viscous_friction_is_no_obstacle():
    """8.5e5 N s/m relaxes slip at 1e8 1/s: an explicit method stops at once with the step that would do; radau5 and
    auto agree, lose no energy unaccounted for, and the slip is the force over the viscosity. Steps of 2e-3 are taken
    whole: their truncation shows in the energy, 1.2e-9."""
    law = ("friction.law=viscous", "friction.viscosity=8.5e5", "time.end=2.0", "time.output_interval=0.1")
    refused = omnisim.simulate(reference_scene("testbench_psi30", *law, "time.step=1e-3"))
    assert "unstable" in refused.attributes["status"] and "use time.step <" in refused.attributes["status"]
    assert refused.attributes["stop_time"] < 0.01
    runs = [run("testbench_psi30", *law, f"time.step={step}", f"solver.method={method}")
            for method, step in (("radau5", 1.25e-3), ("radau5", 1e-3), ("auto", 1e-3))]  # fmt: skip
    coarse, fine, auto = (final_state(trajectory) for trajectory in runs)
    assert np.abs(coarse - fine).max() < 1e-7 and np.abs(auto - fine).max() < 1e-7
    for trajectory in runs:
        balance = np.abs(trajectory["energy/balance"]).max() / trajectory["energy/kinetic"][0]
        assert balance < 1e-9  # measured 3.4e-10, 2.4e-10, 2.4e-10
        slip, force = trajectory["wheels/wheel/slip_velocity"], trajectory["wheels/wheel/friction_force"]
        assert np.abs(8.5e5 * slip + force).max() < 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("scene", either(SCENES, ["free"]))
def test_regularized_friction_converges_to_coulomb_at_first_order_in_the_slip_speed(scene):
    fixed = (*SCENES[scene], *SPAN, "solver.method=radau5")
    coulomb = final_state(run("coulomb_wheel", *fixed, "time.step=1e-4"))
    speeds = 10.0 ** -np.arange(2.0, 8.0)
    errors = []
    for speed in speeds:
        law = ("friction.law=regularized", f"friction.slip_speed={float(speed)!r}", "time.step=1e-3")
        errors.append(np.abs(final_state(run("coulomb_wheel", *fixed, *law)) - coulomb).max())
    slope = np.polyfit(np.log10(speeds), np.log10(errors), 1)[0]
    assert 0.85 < slope < 1.15, errors
    assert errors[-1] < 1e-4 * errors[0]


def test_stiff_slip_is_sought_itself():
    """The authors' vehicle, thrown ahead while it turns: below 1e-6 m/s friction relaxes slip in some 20 ns. With the
    rates for unknowns steps of 2e-4 s failed: 1.84 million right-hand sides in the same two seconds."""
    thrown = ["initial.velocity=[1.0, 0.0]", "time.end=2.0", "solver.method=radau5"]
    coarse, fine = (
        omnisim.simulate(omnisim.load("authors_vehicle", [*thrown, f"time.step={step}"])) for step in (1e-2, 1e-3)
    )
    assert coarse.attributes["rhs_evaluations"] < 400_000  # measured 335,000
    assert distance(coarse, fine) < 5e-8  # measured 1.4e-8; the fine one errs by 3.4e-11


def test_light_rollers_are_no_obstacle():
    """Ia = 1e-9 kg m^2: slip relaxes a thousand times faster than with the rollers of the reference case."""
    runs = [final_state(run("coulomb_wheel", LIGHT, "solver.method=auto", f"time.step={h}")) for h in (2e-3, 1e-3)]
    assert np.abs(runs[0] - runs[1]).max() < 1e-6


def test_a_piece_that_ends_in_rounding_does_not_hold_up_those_behind_it():
    """Rollers that come to rest in their bearings make steps of 50 ms fail; their halves then end at a knot of the
    drive or next to it, in rounding. Wherever knots fall, the run goes on, and to where explicit steps go."""
    bearing = ("wheel_types.omni.roller.bearing_torque=5e-3", "friction.law=viscous", "friction.viscosity=5.0")
    span = (*bearing, "time.end=10.0", "time.output_interval=0.5")
    explicit = final_state(run("testbench_psi30", *span, "solver.method=rk4", "time.step=1e-4"))
    for knots in range(190, 230, 4):
        times = np.linspace(0.0, 10.0, knots).tolist()
        drive = f"wheels.wheel.drive={{kind='torque', times={times}, torque={[0.0] * knots}}}"
        implicit = final_state(run("testbench_psi30", *span, drive, "solver.method=radau5", "time.step=0.05"))
        assert np.abs(implicit - explicit)[:3].max() < 1e-3  # m, rad; measured 2.1e-4


@pytest.mark.short
@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (("solver.method=auto", "time.step=1e-5"), "rk4: friction relaxes slip at up to"),
        (("solver.method=auto", "time.step=1e-2"), "rk4 + radau5"),
        (("solver.method=radau5",), "every step implicit"),
        (("time.step=1e-2",), "and the run stops where it must"),
        (("friction.law=none",), "rk4"),
        (("friction.law=coulomb", "solver.method=auto"), "rk4 + radau5: coulomb friction turns slow slip"),
    ],
)
def test_info_says_which_method_is_used_and_why(overrides, words):
    scene = reference_scene("testbench_psi30", *overrides)
    assert words in explanation(scene.config, packed(scene)[0])


def test_rollers_in_the_air_cost_an_implicit_step_nothing():
    """A machine that stands on four of 72 rollers: 15 right-hand sides for the Jacobian, 24 to 30 for the stages, one
    at the end. Rates of the 28 rollers that could touch as well, but do not, would be 28 more."""
    stands = omnisim.simulate(omnisim.load("robocin_omni_50", {"time.end": 0.01}))
    assert stands.complete and stands.attributes["steps"] == 10
    assert stands.attributes["rhs_evaluations"] <= 10 * 50 + 2  # 444
