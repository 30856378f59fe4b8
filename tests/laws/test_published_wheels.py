"""A published wheel: eight spheres of 16.5 mm on a ring of 59.4 mm carry each corner of a base in another engine.

Source: github.com/PickNikRobotics/moveit_pro_example_ws, pull requests 875 and 913. Published: rolling radius from
71.38 to 75.90 mm; ripple at 1.72, 4.42 and 9.59 Hz predicted, 1.76, 4.44 and 9.68 measured; 0.557 m/s where 0.5 is
commanded by a controller that takes the radius for 66.6 mm. There the base is held at one height, here it is free, on
rubber.
"""

import numpy as np
import pytest

import omnisim

RING, BALL, COUNT = 0.0594, 0.0165, 8
HALF_TRACK, HALF_BASE = 0.2755, 0.319
BELIEVED = 0.0666  # m, radius in the controller
RATES = (1.351, 3.471, 7.532)  # rad/s, of the three published speeds
STEADY = 1.0  # s
MASS, STIFFNESS = 104.0, 3e6


def base(rate: float, right_phase_deg: float = 0.0, end: float = 3.0) -> str:
    """Four such wheels under 100 kg, turned at a rate (rad/s) from 0.5 s on; those on the right may stand between."""
    drive = f'{{ kind = "rate", proportional = 50.0, integral = 100.0, times = [0.0, 0.5], rate = [0.0, {rate}] }}'
    wheels = "".join(
        f"""
        [[wheels]]
        name = "{"front" if x > 0 else "rear"}_{"left" if y > 0 else "right"}"
        type = "balls"
        position = [{x * HALF_BASE}, {y * HALF_TRACK}]
        mirrored = {str(x * y < 0).lower()}
        phase_deg = {right_phase_deg if y < 0 else 0.0}
        drive = {drive}
        """
        for x in (1, -1)
        for y in (1, -1)
    )
    return f"""
        schema = 1
        [scene]
        upright = "free"
        [time]
        end = {end}
        step = 5e-4
        output_interval = 2e-3
        [solver]
        method = "auto"
        [friction]
        law = "regularized"
        coefficient = 0.9
        slip_speed = 0.05
        [wheel_types.balls]
        radius = {RING + BALL}
        roller_distance = {RING}
        roller_count = {COUNT}
        roller_angle_deg = 45.0
        disk = {{ mass = 0.2, inertia_axle = 2e-3, inertia_diameter = 1.2e-3 }}
        roller = {{ mass = 0.1, inertia_axial = 1.1e-5, inertia_transverse = 1.1e-5 }}
        contact = {{ stiffness = {STIFFNESS}, damping = 2e4 }}
        profile = {{ kind = "sphere", radius = {BALL} }}
        [chassis]
        mass = 100.0
        center_of_mass = [0.0, 0.0, 0.15]
        size = [0.96, 0.5, 0.2]
        ground_clearance = 0.05
        {wheels}
        """


def driven(*arguments, **options):
    return omnisim.simulate(omnisim.load_text(base(*arguments, **options)))


def rate_of(run, steady):
    return np.mean([run[f"wheels/{name}/spin_rate"][steady].mean() for name in run.wheels])


def swings(run, path, steady):
    """What of a signal is left without its trend."""
    values = run[path][steady]
    values = values[:, 2] if values.ndim > 1 else values
    return values - np.polyval(np.polyfit(run.time[steady], values, 1), run.time[steady])


def peak(run, values, around):
    """Frequency of the largest part of a signal between half and twice `around`, Hz."""
    padded = 2**17
    frequency = np.fft.rfftfreq(padded, run.time[1] - run.time[0])
    size = np.abs(np.fft.rfft(values * np.hanning(len(values)), padded))
    inside = (frequency > 0.5 * around) & (frequency < 2.0 * around)
    return frequency[inside][np.argmax(size[inside])]


@pytest.mark.long
@pytest.mark.parametrize(("rate", "published"), list(zip(RATES, (1.72, 4.42, 9.59), strict=True)))
def test_ripple_comes_with_every_sphere(rate, published):
    """8 w / 2 pi. Found 1.720, 4.421 and 9.590 Hz."""
    run = driven(rate, end=5.0)
    steady = run.time >= STEADY
    expected = COUNT * rate_of(run, steady) / (2.0 * np.pi)
    assert expected == pytest.approx(published, abs=5e-3)
    assert peak(run, swings(run, "body/position", steady), expected) == pytest.approx(expected, rel=5e-3)


@pytest.mark.long
def test_slow_wheels_roll_on_the_mean_height_of_their_axle():
    """A sphere at azimuth q carries at R1 cos q + r: 71.38 to 75.90 mm, 74.38 on average, less the rubber's sag."""
    run = driven(RATES[0], end=5.0)
    steady = run.time >= STEADY
    low, high = RING * np.cos(np.pi / COUNT) + BALL, RING + BALL
    assert (round(1e3 * low, 2), round(1e3 * high, 2)) == (71.38, 75.90)
    sag = MASS * 9.81 / 4.0 / STIFFNESS
    height = run["body/position"][steady, 2]
    assert np.ptp(height) == pytest.approx(high - low, rel=2e-2)  # 4.49 mm of 4.52
    mean = RING * np.sin(np.pi / COUNT) / (np.pi / COUNT) + BALL
    rolled = run["body/velocity"][steady, 0].mean() / rate_of(run, steady)
    assert rolled == pytest.approx(mean - sag, rel=3e-3)  # 74.19 mm of 74.30; 73.86 and 72.55 as it hops, faster


@pytest.mark.long
def test_a_controller_with_the_wrong_radius_drives_too_fast():
    """Ideal spheres: 0.5 m/s 74.38 / 66.6 = 0.558; published 0.557. Free to hop, the base is two per cent slower."""
    run = driven(0.5 / BELIEVED)
    steady = run.time >= STEADY
    assert run["body/velocity"][steady, 0].mean() == pytest.approx(0.545, abs=0.005)  # 0.5449


@pytest.mark.long
def test_wheels_between_each_other_make_the_base_judder_in_yaw():
    """Left wheels high where right ones are low: each gets ahead of its mean by R1 (sin q - q sin(a)/a), at most 0.23
    mm, so that the base turns to and fro by 0.095 deg; knocks add to that. Published is 1.88 deg, the difference of
    heights by the half track: there wheels hang in the air, and the others turn the base."""
    run = driven(RATES[0], 22.5, end=5.0)
    steady = run.time >= STEADY
    wave = np.degrees(swings(run, "body/yaw", steady))
    assert 0.095 < np.ptp(wave) < 0.2  # 0.140; 0.080 and 0.081 at the higher speeds
    assert peak(run, wave, 1.72) == pytest.approx(1.72, abs=5e-3)  # 1.720 Hz
