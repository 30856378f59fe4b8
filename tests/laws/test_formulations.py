"""The multibody formulation moves as the reduced one does, keeps its constraints, and loads its bearings equally.

Both are marched by dopri5 with steps in which its error is lost; measured values stand beside the bounds.
"""

import tomllib

import numpy as np
import pytest
from helpers.stages import either
from machines import CHASSIS, machine, wheel_mass
from machines import run as simulate
from oracle.cases import REFERENCE
from oracle.scenes import ROWS, SKEW

import omnisim
from omnisim.results.comparison import distance, divergence, energy_error

FORMULATIONS = ("reduced", "multibody")
COULOMB = "friction={law='coulomb', coefficient=0.5}"
SLOPE = "floor={slope_deg=8.0, uphill_deg=70.0}"
SCENES = {
    "bare wheel, regularized": (REFERENCE / "testbench_psi0.toml", 2e-4, []),
    "bare wheel, angled rollers": (REFERENCE / "testbench_psi30.toml", 2e-4, []),
    "bare wheel, coulomb": ("coulomb_wheel", 2e-4, []),
    "implicit tracking": (REFERENCE / "testbench_psi30.toml", 2e-4, ["solver.tracking=implicit"]),
    "kiwi, regularized": (REFERENCE / "kiwi.toml", 1e-4, []),
    "kiwi, coulomb": (REFERENCE / "kiwi.toml", 5e-5, [COULOMB]),
    "mecanum, regularized": (REFERENCE / "mecanum.toml", 1e-5, []),
    "mecanum, coulomb": (REFERENCE / "mecanum.toml", 1e-4, [COULOMB]),
    "bare wheel on a slope, coulomb": ("coulomb_wheel", 2e-4, [SLOPE]),
    "kiwi on a slope, regularized": (REFERENCE / "kiwi.toml", 1e-4, [SLOPE]),
    "unlike wheels on rows, viscous": (SKEW, 5e-5, [*ROWS, "friction.law=viscous"]),
    "unlike wheels on rows, coulomb": (SKEW, 1e-4, [*ROWS, COULOMB]),
    "bearing friction, three types": ("mixed", 2e-4, ["wheel_types.omni.roller.bearing_viscosity=1e-6"]),
}


RESTING, SLOW = 1e-9, 1e-3  # m/s
LONG = "mecanum, regularized"
ENDS = either([(name, end) for end in (0.5, 2.0) for name in SCENES], [(name, 0.5) for name in SCENES if name != LONG])


@pytest.fixture(scope="module", params=ENDS, ids=lambda param: f"{param[0]}, {param[1]} s")
def pair(request):
    name, end = request.param
    scene, step, overrides = SCENES[name]
    time = f"time={{end={end}, step={step}, output_interval=0.01}}"
    solver = ["solver.method=dopri5", time, "output.bearing_loads=true"]
    runs = [
        omnisim.simulate(omnisim.load(scene, [*overrides, *solver, f"solver.formulation={formulation}"]))
        for formulation in FORMULATIONS
    ]
    assert all(run.complete for run in runs)
    return runs


def of_known_direction(run):
    """Rows in which all slip is none or fast. Coulomb friction has its direction, of which slow slip leaves few digits:
    at 3e-5 m/s an error of 4e-11 m/s turns the force by 1e-6 rad."""
    slips = [np.linalg.norm(run[f"wheels/{wheel}/slip_velocity"], axis=1) for wheel in run.wheels]
    known = np.all([(slip < RESTING) | (slip > SLOW) for slip in slips], axis=0)
    assert known.mean() > 0.5
    return known if tomllib.loads(run.attributes["scene"])["friction"]["law"] == "coulomb" else np.ones_like(known)


def test_both_formulations_are_one_motion(pair):
    """Positions, angles and velocities to 1e-9; normal forces to 1e-9 of the weight."""
    last, weight = divergence(*pair)[-1], sum(pair[0][f"wheels/{wheel}/normal_force"][0] for wheel in pair[0].wheels)
    assert max(last.position, last.angle, last.velocity) < 1e-9  # measured: 7e-12, rotating rollers; most 1e-13
    known = of_known_direction(pair[0])
    for path in (f"wheels/{wheel}/normal_force" for wheel in pair[0].wheels):  # measured: 4e-11, kiwi with coulomb
        assert np.abs(pair[0][path] - pair[1][path])[known].max() < 1e-9 * weight  # friction; others below 1e-12


def test_both_see_the_same_events(pair):
    reduced, multibody = pair
    assert reduced["events/kind"].tolist() == multibody["events/kind"].tolist() != []
    np.testing.assert_allclose(reduced["events/time"], multibody["events/time"], rtol=0, atol=1e-9)


def test_multipliers_are_the_loads_that_inverse_dynamics_recovers(pair):
    reduced, multibody = pair
    paths = [path for path in reduced if path.endswith(("bearing_force", "bearing_moment"))]
    assert len(paths) >= 2
    for path in paths:  # measured: 3e-9, kiwi with coulomb friction; the others below 1e-11
        apart = np.abs(reduced[path] - multibody[path])[of_known_direction(reduced)]
        assert apart.max() < 1e-8 * np.abs(reduced[path]).max()


def test_energy_balances_in_both(pair):
    for run in pair:
        assert energy_error(run).relative < 1e-9  # measured: 2e-10 in both, mecanum with regularized friction


def both(scene, *overrides):
    """The scene by dopri5 in both formulations, with the loads of bearings."""
    overrides = [*overrides, "solver.method=dopri5", "output.bearing_loads=true"]
    return [omnisim.simulate(omnisim.load(scene, [*overrides, f"solver.formulation={f}"])) for f in FORMULATIONS]


def test_a_wheel_rests_on_two_rollers_alike():
    """Coasting to rest on an edge: the share of the load, and what both rollers hand on."""
    runs = both(REFERENCE / "testbench_psi30.toml", "time={end=7.5, step=1e-4, output_interval=0.05}")
    for run in runs:
        assert "share_begin" in run["events/kind"]
    reduced, multibody = runs
    rows = reduced.time > 6.62  # before, swings about the edge too short for a step
    assert reduced["wheels/wheel/contact_share"][rows].max() < 1.0
    for name, bound in (("contact_share", 1e-9), ("spin_angle", 1e-9), ("rollers/bearing_force", 1e-6)):
        path = f"wheels/wheel/{name}"  # measured: 1e-11, 1e-13, 2e-8 N
        assert np.abs(reduced[path][rows] - multibody[path][rows]).max() < bound, path


def test_a_wheel_lifts_and_lands_alike():
    """Pressed down behind and released, by coulomb friction: the wheel in the air carries its own weight alone."""
    data = machine(
        "mecanum",
        chassis=CHASSIS | {"center_of_mass": [-0.14, -0.1, 0.1]},
        friction={"law": "coulomb", "coefficient": 0.5},
        wrench={"times": [0.0, 1.0, 2.0], "force": [[0.0, 0.0, 0.0], [0.0, 0.0, -80.0], [0.0, 0.0, 0.0]]},
    )
    time = "time={end=2.0, step=1e-3, output_interval=0.02}"
    reduced, multibody = (
        simulate(data, time, "output.bearing_loads=true", f"solver.formulation={formulation}")
        for formulation in FORMULATIONS
    )
    assert reduced["events/kind"].tolist() == multibody["events/kind"].tolist() == ["lift_off", "touch_down", "stick"]
    np.testing.assert_allclose(reduced["events/time"], multibody["events/time"], rtol=0, atol=1e-12)
    air = multibody["wheels/w0/normal_force"] == 0.0
    weight = wheel_mass("mecanum") * 9.81
    for run in (reduced, multibody):  # measured: 4e-15 N
        assert np.abs(run["wheels/w0/bearing_force"][air] - [0.0, 0.0, weight]).max() < 1e-12


@pytest.mark.parametrize("end", [5.0, pytest.param(100.0, marks=pytest.mark.long)])
def test_constraints_are_kept_for_long(end):
    """A youBot on 36 rollers: residuals of joints, floor and quaternion norms, and the energy; measured in 100 s."""
    overrides = [f"time={{end={end}, step=1e-3, output_interval=0.5}}"]
    reduced, multibody = (
        omnisim.simulate(omnisim.load("youbot", [*overrides, f"solver.formulation={formulation}"]))
        for formulation in FORMULATIONS
    )
    assert multibody.complete
    assert multibody["constraints/position"].max() < 1e-10  # m, rad; measured: 5e-14
    assert multibody["constraints/velocity"].max() < 1e-10  # m/s, rad/s; measured: 4e-14
    drift = multibody["constraints/position_drift"]
    assert 0.0 < drift[-1] < 1e-7  # what each step's projection takes away; measured: 5e-9
    assert (np.diff(drift) >= 0.0).all()
    errors = [energy_error(run).relative for run in (reduced, multibody)]
    assert errors[1] < 10.0 * errors[0] < 1e-6  # measured: 6e-8 and 5e-8


def test_drift_falls_with_the_step():
    """What a step takes a body from its joints is its local error: two fifths of the step, a hundredth of the drift."""
    drifts = []
    for step in ("1e-3", "4e-4"):
        overrides = ["solver.formulation=multibody", f"time={{end=1.0, step={step}, output_interval=0.1}}"]
        run = omnisim.simulate(omnisim.load("six_rollers", overrides))
        drifts.append(run["constraints/position_drift"][-1])
    order = np.log(drifts[0] / drifts[1]) / np.log(2.5)
    assert 4.5 < order < 5.5  # local error of a method of order 4; measured: 5.2


def test_implicit_methods_are_refused_with_what_is_allowed():
    with pytest.raises(omnisim.SceneError, match=r"solver\.method.*'rk4'.*formulation = 'multibody'"):
        omnisim.load("coulomb_wheel", ["solver.formulation=multibody", "solver.method=radau5"])


def test_a_step_is_picked_for_an_error_too():
    overrides = ["solver.formulation=multibody", "solver.error=1e-6", "time.end=0.5"]
    run = omnisim.simulate(omnisim.load("kiwi", overrides))
    exact = omnisim.simulate(omnisim.load("kiwi", ["solver.method=dopri5", "time.end=0.5", "time.step=1e-4"]))
    assert run.attributes["error_estimate"] < 1e-6
    assert distance(run, exact) < 1e-6
