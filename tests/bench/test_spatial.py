"""The benchmarks of machines free in space measure what they say; nothing here is timed."""

import json
import math

import numpy as np
import pytest

from bench import bump_scene, spatial


def total_mass(scene):
    config = scene.config
    (kind,) = config.wheel_types.values()
    return config.chassis.mass + len(config.wheels) * (kind.disk.mass + kind.roller_count * kind.roller.mass)


def test_machines_with_6_and_24_rollers_weigh_the_same_and_their_rollers_relax_alike():
    scenes = [spatial.on_plane(*overrides) for overrides in spatial.COUNTS.values()]
    assert [scene.config.wheel_types["type0"].roller_count for scene in scenes] == [6, 24]
    assert total_mass(scenes[0]) == pytest.approx(total_mass(scenes[1]), rel=1e-15)
    kinds = [scene.config.wheel_types["type0"] for scene in scenes]
    shares = [kind.roller.inertia_axial / (kind.radius - kind.roller_distance) ** 2 for kind in kinds]
    assert shares[1] == pytest.approx(shares[0], rel=0.01)  # kg; measured: 0.04537, 0.04556


@pytest.mark.parametrize("count", spatial.COUNTS)
def test_rolling_on_the_plane_has_exchanges_and_standing_as_many_contacts_as_told(count):
    found = {name: spatial.counted(scenes[count]) for name, scenes in spatial.of_rollers().items()}
    assert found["rolling"]["events"] >= count  # measured: 16, 62
    assert found["rolling"]["contacts"] == pytest.approx({6: 1.20, 24: 1.71}[count], abs=0.02)
    for name, contacts in {"standing on one": 1.0, "standing on two": 2.0}.items():
        assert found[name]["events"] == 0
        assert found[name]["contacts"] == contacts


def test_the_heights_of_the_ground_are_bumps():
    x, y = np.array([0.55, 0.9, 0.67, -0.4]), np.array([0.15, -0.15, 0.15, 0.0])
    expected = [0.012, 0.008, 0.012 / math.e, 0.0]  # what reaches over from the other bump: 7e-6 m at most
    np.testing.assert_allclose(bump_scene.heights(x, y), expected, rtol=0, atol=7e-5)  # measured: 6.5e-5, at 0.67


def test_the_reference_has_no_error_and_a_turned_pose_its_angle():
    known = json.loads(bump_scene.STEM.with_suffix(".json").read_text())
    position, (w, x, y, z) = np.array(known["position"][-1]), known["quaternion"][-1]
    assert bump_scene.errors(position, np.array([-w, -x, -y, -z])) == (0.0, 0.0)  # the same turn
    c, s = math.cos(0.05), math.sin(0.05)  # 0.1 rad about z
    turned = np.array([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w])
    off, angle = bump_scene.errors(position + np.array([0.0, 3e-3, 4e-3]), turned)
    assert off == pytest.approx(5e-3, rel=1e-12)
    assert angle == pytest.approx(0.1, rel=1e-12)


def test_claims_are_a_step_beside_c_and_the_cost_of_rollers():
    rows = {"rows": {"6": {"contacts": 1.1}, "24": {"contacts": 1.4}}, "rhs_ratio": 1.02}
    rollers = {"rolling": {"ratio": 1.05, **rows}, "standing": {"ratio": 1.2, **rows}}
    step, rolling, standing = spatial.claims({"step": {"ratio": 11.0}, "rollers": rollers})
    assert (step.value, step.met, step.alarming) == (11.0, False, False)
    assert (rolling.met, standing.met) == (True, False)
    assert standing.reason.startswith("Of 24 rollers 1.40 touch, of six 1.10; four times the exchanges take 1.02 times")
    assert len(spatial.claims({"step": {}, "rollers": rollers})) == 2  # no compiler


def test_what_24_rollers_take_is_told_by_right_hand_sides_and_by_what_each_takes():
    row = {"ns_per_step": 1000.0, "events": 1, "rhs_per_step": 4.0, "contacts": 1.0}
    rolling = {"rows": {"6": row, "24": row | {"contacts": 2.0}}, "ratio": 1.32, "rhs_ratio": 1.1}
    laws = {"regularized": row, "coulomb": row | {"ns_per_step": 9000.0, "rhs_per_step": 6.0}}
    said = spatial.report({"step": {}, "rollers": {"rolling": rolling}, "laws": laws, "bumps": []})
    assert "takes 9.0 times as long, rolling: 1.5 times by right-hand sides and 6.0 times" in said
    assert "1.32 times as long as 6: 1.10 times by right-hand sides at events, 1.20 times" in said
    assert "| rolling | 24 | 1000 | 1 | 4.00 | 2.00 | 250 |" in said


def test_an_engine_over_bumps_is_judged_by_a_march_that_is_a_thousand_times_closer():
    def ours(error, ratio):
        return {"method": "rk4", "step": 1e-5, "position_error": error, "ratios": {bump_scene.BEST: ratio}}

    best = {"position_error": 1e-1}
    (claim,) = bump_scene.claims("An engine", {"best": best, "omnisim": [ours(1e-5, 3.0), ours(2e-4, 9.0)]})
    assert (claim.value, claim.met) == (3.0, True)
    (claim,) = bump_scene.claims("An engine", {"best": best, "omnisim": [ours(2e-4, 9.0)]})
    assert (claim.value, claim.met) == (0.0, False)
    (claim,) = bump_scene.claims("An engine", {"best": best, "omnisim": [ours(1e-5, 0.9)]})
    assert not claim.met and claim.reason.endswith("its error is 1e+04 times smaller")
    assert bump_scene.claims("An engine", {}) == []


@pytest.fixture
def mujoco():
    return pytest.importorskip("mujoco", reason="needs MuJoCo")


def test_the_machine_over_bumps_in_mujoco_has_the_mass_of_the_scene(mujoco):
    from bench.peers import mujoco_ground

    model = mujoco_ground.model(mujoco_ground.Setup("ellipsoid, level", "2 steps", "Euler", 1e-3, 0.04))
    assert model.body_mass.sum() == pytest.approx(total_mass(bump_scene.bumps()), rel=1e-14)
    peaks = np.array(model.hfield_data) * model.hfield_size[0, 2]
    assert peaks.max() == pytest.approx(0.012, rel=0.02)  # measured: 0.0119


def test_a_contact_in_mujoco_can_be_the_rubber(mujoco):
    """N = stiffness depth + damping rate in every contact of a machine that sinks in."""
    from bench.peers import mujoco_ground

    setup = mujoco_ground.Setup("ellipsoid, level", mujoco_ground.RUBBER, "Euler", 1e-4, 0.04)
    run = mujoco_ground.Running(setup)
    run.data.qpos[2] = -1e-3
    run.data.qvel[:] = 0.0
    run.data.qvel[2] = -0.01
    mujoco.mj_forward(run.model, run.data)
    rubber, contacts = bump_scene.wheel_type().contact, run.data.contact
    assert len(contacts) >= 4
    found = np.zeros((len(contacts), 6))
    for number, force in enumerate(found):
        mujoco.mj_contactForce(run.model, run.data, number, force)
    expected = -rubber.stiffness * contacts.dist - rubber.damping * run.data.efc_vel[contacts.efc_address]
    np.testing.assert_allclose(found[:, 0], expected, rtol=0, atol=0.01 * expected.max())  # measured: 0.008 of it


def test_on_flat_ground_the_machine_in_mujoco_goes_nearly_as_far(mujoco):
    from bench.peers import mujoco_ground

    setup = mujoco_ground.Setup(mujoco_ground.MESH, mujoco_ground.RUBBER, "implicitfast", 2e-4, 0.04)
    run = mujoco_ground.Running(setup)
    run.model.hfield_data[:] = 0.0
    run.go()
    assert run.data.qpos[0] == pytest.approx(1.21, rel=0.1)  # omnisim: 1.2106 m; measured: 1.131, on a plane 1.196


@pytest.fixture
def drake():
    from bench.peers import drake_peer

    if drake_peer.MISSING:
        pytest.skip(drake_peer.MISSING)


def test_the_machine_over_bumps_in_drake_has_the_mass_of_the_scene(drake):
    from bench.peers import drake_bumps

    machine = drake_bumps.Machine(drake_bumps.Setup("ellipsoid, level", "TAMSI", 1e7, 1e-3))
    context = machine.plant.CreateDefaultContext()
    assert machine.plant.CalcTotalMass(context) == pytest.approx(total_mass(bump_scene.bumps()), rel=1e-14)


@pytest.mark.long
def test_the_benchmark_over_bumps_in_mujoco_runs_and_reports(mujoco):
    from bench.peers import mujoco_bumps

    result = mujoco_bumps.measure(1)
    assert "of MuJoCo takes" in mujoco_bumps.report(result)
    json.dumps(result)


@pytest.mark.long
def test_the_benchmark_of_a_free_machine_runs_and_reports():
    result = spatial.measure(1)
    assert "Over two bumps" in spatial.report(result)
    json.dumps(result)
