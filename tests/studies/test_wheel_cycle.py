"""Wheels side by side: what they show is known where rollers neither slip nor lose anything."""

import numpy as np
import pytest

import omnisim
from omnisim.scene.scene import load_text
from omnisim.studies import wheel_cycle
from omnisim.studies.wheel_cycle import CURES, CYCLE, MASS, Platform, candidates, compare_wheels, driven, usual_mass

STIFF = "friction={law='regularized', coefficient=0.6, slip_speed=0.02}"


@pytest.fixture(scope="module")
def compared():
    """youBot's mecanum wheels and omni wheels of a soccer robot."""
    wheels = candidates([omnisim.load(name) for name in ("youbot", "soccer_robot")])
    return dict(zip(("mecanum", "omni"), compare_wheels(wheels, 20.0), strict=True))


@pytest.mark.long
def test_mecanum_wheels_go_sideways_slower_by_the_mean_cosine_of_their_rollers_azimuth(compared):
    """A roller at azimuth q that does not slip lets the wheel go sideways at phi' R cos q / tan(psi): at a constant
    rate sin(alpha) / alpha of the ideal, on average over its sector; the controllers do not hold it quite."""
    alpha = np.pi / 6.0
    slower = compared["mecanum"]["sideways"].speed
    assert slower == pytest.approx(np.sin(alpha) / alpha - 1.0, abs=5e-4)  # -0.0453 and -0.0451
    assert abs(compared["mecanum"]["forward"].speed) < 1e-5  # 3e-6


def test_exact_rollers_that_do_not_slip_lose_nothing(compared):
    for motions in compared.values():
        assert abs(motions["forward"].drag) < 1e-3  # N; 1.5e-7 and 6e-6
        assert motions["forward"].height is None  # held upright
    assert compared["omni"]["turning"].ripple < 1e-5 < 1e-2 < compared["mecanum"]["sideways"].ripple


def test_loads_are_of_a_quarter_of_the_weight(compared):
    """On the way straight ahead nothing but the controllers' last correction moves the load."""
    assert compared["mecanum"]["forward"].load == pytest.approx(1.0, abs=1e-3)  # 2e-4
    assert compared["mecanum"]["sideways"].load > 1.2


@pytest.mark.parametrize("scene", ["youbot", "kiwi", "fm202", "rocker"])
def test_the_platform_goes_where_it_is_told(scene):
    """Ideal wheels at the commanded rates, whatever the wheel's angle and hand: kinematics alone, no run."""
    from omnisim.scene.ideal_kinematics import wheel_rows

    (wheel,) = candidates([omnisim.load(scene)])
    platform = Platform(wheel, max(MASS, 10.0 * usual_mass([wheel])), 0.5)
    for motion, direction in CYCLE.items():
        config = load_text(platform.scene(motion)).config
        rates = wheel_rows(config) @ config.command.twist[-1]
        twist, *_ = np.linalg.lstsq(wheel_rows(config), rates, rcond=None)
        assert np.allclose(twist * [1.0, 1.0, platform.arm], 0.5 * np.array(direction), atol=1e-12)


def test_a_left_hand_wheel_gives_the_same_table():
    scene = omnisim.load("youbot")
    other = omnisim.load("youbot", {"wheel_types.mecanum.roller_angle_deg": -45.0})
    one, two = (Platform(wheel, 20.0, 0.5) for wheel in candidates([scene, other]))
    assert [entry["mirrored"] for entry in one.places()] == [not entry["mirrored"] for entry in two.places()]


def test_the_first_machine_gives_the_mass():
    bare, machine = omnisim.load("coulomb_wheel"), omnisim.load("youbot")
    assert usual_mass(candidates([bare])) == MASS
    assert usual_mass(candidates([bare, machine])) == pytest.approx(22.8)


def test_every_type_in_use_is_a_candidate():
    assert [wheel.name for wheel in candidates([omnisim.load("mixed"), omnisim.load("kiwi")])] == [
        "mixed:mecanum",
        "mixed:omni",
        "kiwi",
    ]


def test_a_platform_lighter_than_its_wheels_is_refused():
    (wheel,) = candidates([omnisim.load("youbot")])
    with pytest.raises(ValueError, match="four wheels of youbot weigh more than the platform of 1 kg; see --mass"):
        compare_wheels([wheel], 1.0)


def test_energy_is_given_and_not_taken_back():
    """Work of the drives while they push, by the trapezoidal rule over rows of a run with a known power."""
    (wheel,) = candidates([omnisim.load("kiwi")])
    platform = Platform(wheel, 20.0, 0.5)
    run = omnisim.simulate(load_text(platform.scene("forward")))
    steady = run.time >= 0.0
    pushed = platform.given(run, steady)
    braked = sum(np.trapezoid(np.minimum(run[f"wheels/{name}/drive_power"], 0.0), run.time) for name in run.wheels)
    assert pushed + braked == pytest.approx(run["energy/drive_work"][-1], rel=1e-3)  # rows are 2 ms apart
    assert pushed > run["energy/kinetic"][-1]


def turning_alone(monkeypatch) -> tuple:
    """Wheels whose rollers slip too slowly for rk4 at their step, and what is found of them as they turn around."""
    monkeypatch.setattr(wheel_cycle, "CYCLE", {"turning": CYCLE["turning"]})
    wheels = candidates([omnisim.load("youbot", [STIFF])])
    return wheels, compare_wheels(wheels, 20.0)[0]["turning"]


def test_a_motion_that_its_step_does_not_carry_is_repeated_by_radau5(monkeypatch):
    (wheel,), found = turning_alone(monkeypatch)
    assert found.cure == CURES[0]
    (stopped,) = driven([(Platform(wheel, 20.0, 0.5), "turning")], None)
    assert "too fast for rk4 with time.step = 0.0005 s" in stopped


@pytest.mark.long
def test_a_fifth_of_that_step_tells_the_same(monkeypatch):
    (wheel,), found = turning_alone(monkeypatch)
    (finer,) = driven([(Platform(wheel, 20.0, 0.5), "turning")], CURES[1])
    for name in ("speed", "ripple", "drag", "energy", "load"):
        assert abs(getattr(found, name) - getattr(finer, name)) < 1e-6, name  # measured 4e-7, the energy, of 12 J/m
