"""Drives that follow a table of angles: the motion is given, and the torque that it takes is what comes out."""

import numpy as np
import pytest
from machines import BOX, axle_inertia, machine, run, scene
from scipy.interpolate import CubicSpline

import omnisim
from omnisim.results.comparison import energy_error
from omnisim.scene.scene import SceneError

TIMES = [0.0, 0.12, 0.3, 0.35, 0.6, 1.0]
ANGLES = [0.2, 0.9, 0.4, 0.45, -1.5, 1.0]
FOLLOW = {"kind": "follow", "times": TIMES, "angle": ANGLES}
RATE = 3.0  # rad/s, at the start
RING = [(0.2 * np.cos(a), 0.2 * np.sin(a)) for a in 2.0 * np.pi / 3.0 * np.arange(3)]
HEADINGS = (90.0, 210.0, 330.0)
SMOOTH = {"law": "viscous", "viscosity": 20.0}
COULOMB = {"law": "coulomb", "coefficient": 0.5}


def ring(drives, friction, **changed):
    """Three omni wheels; start: the spin rate of a drive's wheel."""
    own = [{key: value for key, value in drive.items() if key != "start"} for drive in drives]
    data = machine("omni", RING, HEADINGS, own, friction=friction, **changed)
    for wheel, drive in zip(data["wheels"], drives, strict=True):
        wheel["spin_rate"] = drive.get("start", RATE)
    return data


@pytest.mark.parametrize("method", ["rk4", "dopri5", "radau5"])
def test_the_wheel_turns_as_the_cubic_through_its_angles_and_the_torque_is_that_of_its_inertia(method):
    """Nothing else turns a wheel without friction: tau = J_k phi''. SciPy has the cubic."""
    data = machine("mecanum", drives=[FOLLOW])
    data["wheels"][0]["spin_rate"] = RATE
    found, cubic = run(data, f"solver.method={method}"), CubicSpline(TIMES, ANGLES, bc_type=((1, RATE), (2, 0.0)))
    for order, name in enumerate(("angle", "rate", "acceleration")):
        values = cubic(found.time, order)
        assert np.abs(found[f"wheels/w0/spin_{name}"] - values).max() < 1e-13 * np.abs(values).max()  # measured: 3e-15
    torque, rate = axle_inertia("mecanum") * cubic(found.time, 2), cubic(found.time, 1)
    assert np.abs(found["wheels/w0/drive_torque"] - torque).max() < 1e-13 * np.abs(torque).max()  # measured: 4e-15
    work = 0.5 * axle_inertia("mecanum") * (rate**2 - RATE**2)
    assert np.abs(found["energy/drive_work"] - work).max() < 1e-12 * np.abs(work).max()  # measured: 3e-14
    assert not found["body/velocity"].any(), "the others do not notice"


def driven(step):
    """A machine that torques drive over a smooth floor, for as long as no roller gives way to the next."""
    torques = [
        {"kind": "torque", "times": [0.0, 0.08], "torque": list(pair)} for pair in ((0.3, -0.1), (0.1, 0.2), (0.2, 0.2))
    ]
    return ring(torques, SMOOTH, time={"end": 0.08, "step": step, "output_interval": 5e-4})


def test_angles_that_torques_have_made_take_these_torques_again():
    """The error of the cubic is of fourth order in the angles, of second in what turns them."""
    first, errors = run(driven(2.5e-5)), []
    assert "exchange" not in first["events/kind"]
    for every in (16, 8, 4):
        tables = [
            {"kind": "follow", "times": first.time[::every].tolist(), "angle": angle[::every].tolist()}
            for angle in (first[f"wheels/{wheel}/spin_angle"] for wheel in first.wheels)
        ]
        again = run(ring(tables, SMOOTH, time={"end": 0.08, "step": 2.5e-5, "output_interval": 5e-4}))
        inner = slice(40, -40)  # the last piece of a natural cubic bends too little
        errors.append(
            [
                np.abs(again["body/position"] - first["body/position"]).max(),
                max(np.abs(again[path] - first[path])[inner].max() for path in torques(first)),
            ]
        )
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders[:, 0].min() > 2.5 and orders[:, 1].min() > 1.7, (errors, orders)
    assert errors[-1][0] < 1e-8 and errors[-1][1] < 1e-3, errors  # m, N m


def torques(found):
    return [f"wheels/{wheel}/drive_torque" for wheel in found.wheels]


LAWS = {
    "viscous": SMOOTH,
    "regularized": {"law": "regularized", "coefficient": 0.5, "slip_speed": 0.1},
    "coulomb": COULOMB,
}


@pytest.mark.parametrize("law", LAWS)
def test_both_formulations_take_the_same_torques(law):
    drives = [
        FOLLOW | {"angle": [share * angle for angle in ANGLES], "start": share * RATE} for share in (1.0, 0.6, -0.8)
    ]
    data = ring(drives, LAWS[law], time={"end": 0.4, "step": 1e-4, "output_interval": 0.01})
    pair = [
        run(data, "solver.method=dopri5", f"solver.formulation={formulation}")
        for formulation in ("reduced", "multibody")
    ]
    assert {"exchange"} | ({"stick", "slip"} if law == "coulomb" else set()) <= set(pair[0]["events/kind"])
    reduced, multibody = pair
    for path in ("body/position", "body/yaw"):
        assert np.abs(reduced[path] - multibody[path]).max() < 1e-10  # m, rad; measured: 8e-13
    for path in torques(reduced):
        assert np.abs(reduced[path] - multibody[path]).max() < 1e-7  # N m, of 1; measured: 8e-9, of sticking wheels
    for found in pair:
        scale = np.abs(found["energy/drive_work"]).max()
        assert np.abs(found["energy/balance"]).max() < 1e-7 * scale  # measured: 1.5e-8, regularized; others 1e-12


def test_wheels_that_hold_the_floor_move_the_machine_as_their_spins_say():
    """Three wheels that give no way and do not slip leave the machine no freedom: any step gives the same motion."""
    drives = [
        {"kind": "follow", "times": [0.0, 0.5, 1.0], "angle": [0.0, 0.4 * share, 1.6 * share], "start": 0.0}
        for share in (1.0, -0.5, 0.3)
    ]
    found = [
        run(ring(drives, COULOMB, time={"end": 1.0, "step": step, "output_interval": 0.01})) for step in (1e-3, 2.5e-4)
    ]
    slips = np.stack([np.linalg.norm(found[0][f"wheels/{wheel}/slip_velocity"], axis=1) for wheel in found[0].wheels])
    assert {"slip", "stick"} <= set(found[0]["events/kind"])  # for a moment behind every exchange
    assert slips.max() < 1e-11  # m/s, in every row
    assert np.abs(found[0]["body/position"] - found[1]["body/position"]).max() < 1e-12  # m; measured: 1.5e-14
    for coarse in found:
        assert energy_error(coarse).relative < 1e-9  # measured: 2e-11


def test_the_loop_gives_no_input_to_a_table():
    loop = omnisim.Loop(scene(machine("mecanum", drives=[FOLLOW])))
    with pytest.raises(ValueError, match="wheel 'w0' has a drive of kind 'follow', which takes no input"):
        loop.drive("w0", 1.0)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"times": [0.0]}, "drive"),
        ({"times": [0.1, *TIMES[1:]]}, "must be two times or more, without repetition, from 0 to time.end = 1"),
        ({"times": [*TIMES[:-1], 0.9]}, "must be two times or more, without repetition, from 0 to time.end = 1"),
        ({"times": [0.0, 0.3, 0.3, 0.35, 0.6, 1.0]}, "must be two times or more, without repetition"),
        ({"angle": ANGLES[:-1]}, "angle"),
        ({"angle": 1.0}, "angle"),
        ({"angel": ANGLES}, "angel"),
        ({"rate": 1.0}, "not a key of a drive with kind = 'follow'"),
    ],
)
def test_tables_that_do_not_tell_the_spin_of_the_whole_run_are_refused(changed, told):
    with pytest.raises(SceneError, match=told):
        scene(machine("mecanum", drives=[FOLLOW | changed]))


def test_a_wheel_that_stands_elsewhere_is_refused():
    data = machine("mecanum", BOX, drives=[FOLLOW])
    data["wheels"][0]["spin_angle_deg"] = 10.0
    with pytest.raises(
        SceneError, match=r"spin_angle_deg = 10.*must be absent, or where the angles of the drive begin"
    ):
        scene(data)
