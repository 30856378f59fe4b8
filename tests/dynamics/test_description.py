"""What `info` says is modelled is what is integrated."""

import pytest
from scenes import packed, reference_scene
from vehicles import FOLLOWING, VEHICLE

from omnisim.base.formatting import WIDTH
from omnisim.dynamics.description import describe
from omnisim.dynamics.packing import pack
from omnisim.scene.scene import load, packaged_scenes

pytestmark = pytest.mark.short


def model_of(scene):
    return describe(scene.config, pack(scene.config))


def modelled(scene):
    return {part.name for part in model_of(scene).parts if part.modelled}


def why(scene, name):
    return next(part.why for part in model_of(scene).parts if part.name == name)


@pytest.fixture
def vehicle(tmp_path):
    """A vehicle of four mecanum wheels: (text, overrides) -> Scene."""

    def scene(text, *overrides):
        (tmp_path / "vehicle.toml").write_text(text)
        return load(tmp_path / "vehicle.toml", overrides)

    return scene


@pytest.mark.parametrize("bearings", [False, True])
@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
@pytest.mark.parametrize("name", packaged_scenes())
def test_the_states_counted_are_the_states_integrated(name, tracking, bearings):
    kind = next(iter(load(name).config.wheel_types))
    rough = [f"wheel_types.{kind}.roller.bearing_viscosity=1e-6"] if bearings else []
    if load(name).config.upright == "free" and tracking == "implicit":
        pytest.skip("machines free in space have no implicit tracking")
    scene = load(name, [f"solver.tracking={tracking}", *rough])
    model = model_of(scene)
    assert model.states == len(packed(scene)[1].y)
    assert all(part.modelled or not part.states for part in model.parts)
    assert f"{model.states} states" in model.line
    assert "\n" not in model.line and len(model.line) < 200  # 151 for four wheels on rate drives
    assert max(map(len, model.text.splitlines())) <= WIDTH


def test_only_what_the_scene_needs_is_modelled():
    def of_wheel(*overrides):
        return modelled(reference_scene("testbench_psi30", *overrides))

    plain = of_wheel()
    assert "rollers in the air" not in plain
    assert of_wheel("friction.law=none") == plain - {"friction"}
    assert of_wheel("wheels.wheel.drive={kind='torque', torque=1.0}") == plain | {"torque drive"}
    assert of_wheel("wrench.times=[0]", "wrench.force=[[1, 0, 0]]") == plain | {"wrench"}
    assert of_wheel("floor.slope_deg=5") == plain | {"slope"}
    assert of_wheel("solver.tracking=implicit") == plain | {"rho"}
    bearings = of_wheel("wheel_types.omni.roller.bearing_viscosity=1e-6")
    assert bearings == plain | {"roller rates", "bearing friction"}


def test_a_machine_has_the_states_of_its_wheels_drives_and_odometry():
    states = {part.name: part.states for part in model_of(load("youbot")).parts if part.states}
    assert states == {"plane motion": 6, "spin": 8, "rollers in contact": 8, "drive integrals": 4, "works": 3,
                      "odometry": 2}  # fmt: skip


def test_a_machine_free_in_space_has_a_body_of_six_degrees_of_freedom_and_what_carries_its_wheels():
    states = {part.name: part.states for part in model_of(load("cable_duct")).parts if part.states}
    assert states == {"rigid body": 13, "spin": 8, "suspensions": 8, "rollers in contact": 32, "drive integrals": 4,
                      "works": 5, "odometry": 2}  # fmt: skip
    springs, rocker, ramp = (modelled(load(name)) for name in ("cable_duct", "rocker", "kiwi_ramp"))
    assert springs - rocker == {"suspensions"} and rocker - springs == {"rockers"}
    assert ramp - springs == {"slope"} and springs - ramp == {"suspensions"}
    assert not {"plane motion", "servo", "heave, roll and pitch", "compliance"} & springs
    assert why(load("cable_duct"), "floor").startswith("2 steps; ")
    assert why(load("rocker"), "floor").startswith("2 bumps, 1 pit; ")
    assert why(load("kiwi_ramp"), "floor") == "a plane" and "2 rows" in why(load("kiwi_ramp"), "profile")
    assert why(load("rocker"), "rockers") == "turn freely: 'front' (front_left, front_right) about x"


def test_only_what_the_machine_needs_is_modelled(vehicle):
    plain = modelled(vehicle(VEHICLE))
    assert {"chassis", "odometry", "normal forces"} < plain
    assert modelled(vehicle(VEHICLE, "scene.upright=servo")) == plain | {"servo"}
    assert modelled(vehicle(FOLLOWING)) == plain | {"rate drive", "command"}
    integral = "wheels.fl.drive={kind='rate', proportional=0.5, integral=1.0}"
    assert modelled(vehicle(FOLLOWING, integral)) == plain | {"rate drive", "command", "drive integrals"}
    straight = "wheel_types.mecanum.roller_angle_deg=0.0"
    assert modelled(vehicle(VEHICLE, straight)) == plain - {"odometry"}
    assert "sideways motion" in why(vehicle(VEHICLE, straight), "odometry")


def test_each_kind_of_drive_is_told_once_with_its_wheels(vehicle):
    motor = "wheels.rr.drive={kind='dc_motor', voltage=6.0, resistance=1.2, torque_constant=0.02, rotor_inertia=1e-5}"
    scene = vehicle(VEHICLE, motor, "wheels.fl.drive={kind='rate', rate=3.0, proportional=0.5, torque_limit=2.0}",
                    "wheels.fr.drive={kind='rate', times=[0, 1], rate=[0, 1], proportional=0.5}")  # fmt: skip
    rate = why(scene, "rate drive")
    assert rate.startswith("fl: rate 3 rad/s") and "; fr: rate by table of 2 points" in rate
    assert rate.count("event") == 1  # only one has a limit
    assert why(scene, "dc_motor drive").startswith("rr: voltage 6 V; 1.2 ohm")
    assert why(scene, "drive") == "rl: spinning freely"
    left_out = {part.name for part in model_of(scene).parts} - modelled(scene)
    assert {"motor inductance", "rotor gyroscopy", "drive"} < left_out
    assert why(vehicle(FOLLOWING), "rate drive").startswith("all wheels: rate of the command")


def test_loads_are_exact_on_three_wheels_only():
    assert "exactly" in why(load("kiwi"), "normal forces")
    assert "equal springs" in why(load("youbot"), "normal forces")
    assert "equal shares" in why(load("youbot", ["scene.upright=servo"]), "normal forces")


def test_bearing_friction_names_the_types_that_have_it():
    scene = load("mixed", ["wheel_types.omni.roller.bearing_torque=1e-5"])
    assert why(scene, "bearing friction").startswith("type 'omni': ") and "mecanum" not in why(
        scene, "bearing friction"
    )


def test_keys_that_the_law_does_not_use_are_named():
    text = model_of(reference_scene("testbench_psi30", "friction.viscosity=2.0")).text
    assert "not used by this scene: friction.viscosity" in text
