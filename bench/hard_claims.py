"""What is claimed of the motion in hard cases: closed forms if there are any, else another method or a finer step."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import omnisim
from omnisim.results.trajectory import Trajectory


class Comparison(NamedTuple):
    """What was measured: an error below its bound, and against what (units: m, rad, s, m/s or rad/s, the larger)."""

    error: float
    bound: float
    against: str


@dataclass(frozen=True)
class Case:
    """A scene, why it is hard, the method and step (s) that master it, and what is claimed of the run.

    stops: words of the sentence with which the run ends early.
    """

    name: str
    hard: str
    scene: str
    overrides: tuple[str, ...]
    claim: Callable[["Case", Trajectory], Comparison]
    method: str = "rk4"
    step: float = 1e-3
    stops: str = ""

    def run(self, *overrides: str) -> Trajectory:
        """The motion, with further overrides."""
        solver = (f"solver.method={self.method}", f"time.step={self.step!r}")
        return omnisim.simulate(omnisim.load(self.scene, (*solver, *self.overrides, *overrides)))


class Body(NamedTuple):
    """The wheel of a scene with rollers along its rim: what closed forms need."""

    mass: float  # kg, all of it
    radius: float  # m
    axle: float  # J_k, kg m^2
    rolling: float  # inverse mass of the contact along h, 1/kg
    sideways: float  # inverse mass of the contact along k in the middle of a roller, 1/kg
    weight: float  # N
    limit: float  # mu N, N
    alpha: float  # half the angle between two rollers, rad

    @classmethod
    def of(cls, scene: str, *overrides: str) -> "Body":
        config = omnisim.load(scene, overrides).config
        (kind,) = config.wheel_types.values()
        count, disk, roller, radius = kind.roller_count, kind.disk, kind.roller, kind.radius
        mass = disk.mass + count * roller.mass
        axle = disk.inertia_axle + count * (roller.mass * kind.roller_distance**2 + roller.inertia_transverse)
        weight = mass * config.world.gravity
        sideways = 1 / mass + (radius - kind.roller_distance) ** 2 / roller.inertia_axial
        limit = config.friction.coefficient * weight
        return cls(mass, radius, axle, 1 / mass + radius**2 / axle, sideways, weight, limit, np.pi / count)


WHEEL = Body.of("coulomb_wheel")
SIX = Body.of("six_rollers")
LIGHT = "wheel_types.omni.roller.inertia_axial=1e-9"
STILL = ("initial.velocity=[0, 0]", "wheels.wheel.spin_rate=0")
FREE = "friction.law=none"
SWINGS, SWING, SHAKE = 1000, 0.05, 0.1  # half swings, time of one (s) and torque (N m) of a wheel rocked by its drive
ROCK = SHAKE * SWING / 2 / (WHEEL.axle + WHEEL.mass * WHEEL.radius**2)  # its spin rate on the edge, rad/s
BRAKE = 0.01  # N m
SPIN = float(np.sqrt(2.0 * BRAKE * SIX.alpha / SIX.axle))  # spin rate that BRAKE ends after half a roller, rad/s
PULL = 2.0 * WHEEL.limit * WHEEL.rolling * WHEEL.axle / WHEEL.radius  # N m: twice what friction can hold
SPUN = WHEEL.radius * 30.0 / (WHEEL.limit * WHEEL.rolling)  # time in which a spin of 30 rad/s comes to roll, s
SPUN_ANGLE = 30.0 * SPUN - WHEEL.limit * WHEEL.radius / WHEEL.axle * SPUN**2 / 2
JUMPS = np.concatenate([[0.0], np.sort(np.random.default_rng(1).uniform(0.0, 2.0, 49)), [2.0]])  # s
TORQUES = np.random.default_rng(2).uniform(-0.1, 0.1, 50)  # N m


def torque(*values: float, times: tuple[float, ...] = ()) -> str:
    """Override: a constant drive torque (N m), or a table of it."""
    if not times:
        return f"wheels.wheel.drive={{kind='torque', torque={values[0]!r}}}"
    return f"wheels.wheel.drive={{kind='torque', times={list(times)}, torque={list(values)}}}"


def steps_of(values: list[float], times: list[float]) -> str:
    """Override: a drive torque that jumps from one constant value to the next at `times` (one less than values)."""
    return torque(*np.repeat(values, 2)[1:-1].tolist(), times=tuple(np.repeat(times, 2).tolist()))


def wrench(*forces: tuple[float, float, float], times: tuple[float, ...] = (0.0,), frame: str = "world") -> str:
    """Override: a table of the external force, N."""
    return f"wrench={{frame='{frame}', times={list(times)}, force={[list(force) for force in forces]}}}"


def apart(a: Trajectory, b: Trajectory) -> float:
    """Largest difference of position (m), yaw and spin angles (rad) in any row."""
    return worst(motion(a), motion(b))


def motion(run: Trajectory) -> np.ndarray:
    """Position, yaw and spin angles in every row (T, 4 + W)."""
    spins = [run[f"wheels/{wheel}/spin_angle"] for wheel in run.wheels]
    return np.column_stack([run["body/position"], run["body/yaw"], *spins])


def speeds(run: Trajectory) -> np.ndarray:
    """Forward velocity and spin rate in every row (T, 2)."""
    return np.column_stack([run["body/velocity"][:, 0], run["wheels/wheel/spin_rate"]])


def worst(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference; infinite if there are more of one than of the other."""
    found, expected = np.asarray(found), np.asarray(expected)
    return float(np.abs(found - expected).max(initial=0.0)) if found.shape == expected.shape else np.inf


def times_of(run: Trajectory, kind: str) -> np.ndarray:
    """Times of the events of one kind, s."""
    return run["events/time"][run["events/kind"] == kind]


def friction_power(run: Trajectory) -> float:
    """Largest power of friction in any row, W: never positive but for rounding."""
    paths = ((f"wheels/{wheel}/friction_force", f"wheels/{wheel}/slip_velocity") for wheel in run.wheels)
    return max(float(np.sum(run[force] * run[slip], axis=1).max()) for force, slip in paths)


def converged(bound: float, *overrides: str) -> Callable[[Case, Trajectory], Comparison]:
    """Comparison: the same motion with a finer step or another method."""
    keys = ("solver.method=", "time.step=", "friction.law=")
    values = [override.removeprefix(key) for override in overrides for key in keys if override.startswith(key)]

    def claim(case: Case, run: Trajectory) -> Comparison:
        return Comparison(apart(run, case.run(*overrides)), bound, ", ".join(values))

    return claim


def provided(claim: Callable, happens: Callable[[Trajectory], bool], told: str) -> Callable:
    """The claim of a run in which this happens, as told."""

    def both(case: Case, run: Trajectory) -> Comparison:
        found = claim(case, run)
        return found._replace(error=found.error if happens(run) else np.inf, against=f"{found.against}; {told}")

    return both


def first_order(case: Case, run: Trajectory) -> Comparison:
    """The regularized law tends to coulomb friction, in proportion to slip_speed: a tenth of it, ten times nearer."""
    exact = case.run("friction.law=coulomb", "time.step=1e-4")
    near, far = apart(run, exact), apart(case.run("friction.slip_speed=1e-6"), exact)
    return Comparison(abs(far / near - 10.0), 0.5, f"coulomb, {near:.1e} away: a tenth of 1e-6")


def spin_up(case: Case, run: Trajectory) -> Comparison:
    """A light roller slides for 0.3 m/s / (mu N A) before it rolls."""
    stop = 0.3 / (WHEEL.limit * Body.of(case.scene, *case.overrides).sideways)
    return Comparison(worst(times_of(run, "stick"), [stop]) / stop, 1e-9, f"time of sliding, {stop:.2g} s, relative")


def coasts_on_two_rollers(case: Case, run: Trajectory) -> Comparison:
    """In the end the wheel spins no more and rolls along (s, c cos alpha), where both rollers under it roll freely."""
    yaw, velocity = run["body/yaw"][-1], run["body/velocity"][-1, :2]
    (kind,) = omnisim.load(case.scene).config.wheel_types.values()
    psi, alpha = np.radians(kind.roller_angle_deg), np.pi / kind.roller_count
    forward, left = velocity @ [np.cos(yaw), np.sin(yaw)], velocity @ [-np.sin(yaw), np.cos(yaw)]
    aslant = abs(forward * np.cos(psi) * np.cos(alpha) - left * np.sin(psi))
    error = max(apart(run, case.run("time.step=1e-4")), aslant, abs(run["wheels/wheel/spin_rate"][-1]))
    return Comparison(error, 1e-7, "1e-4, and the direction in which both rollers roll")


def swings(case: Case, run: Trajectory) -> Comparison:
    """A gyroscopic pendulum: one spinning roller couples spin and yaw, so the wheel swings about a common edge.

    With G_n = Q cos(delta), delta the angle from the edge, I theta' + G_n = L and J phi'^2 + I theta'^2 = 2E; a half
    swing takes the integral of d(delta) / phi' between the turning points, in which the integrand of the phase u,
    sin(delta/2) = sin(a/2) sin u, is smooth and periodic.
    """
    config, rates = omnisim.load(case.scene, case.overrides).config, run["wheels/wheel/rollers/axial_rate"][0]
    (kind,) = config.wheel_types.values()
    count, disk, roller = kind.roller_count, kind.disk, kind.roller
    q_mass = count * roller.mass * kind.roller_distance**2
    yaw_inertia = disk.inertia_diameter + q_mass / 2 + count * roller.inertia_transverse / 2
    gyro = roller.inertia_axial * float(rates @ np.cos(2.0 * SIX.alpha * np.arange(count)))
    spin_rate, yaw_rate = config.wheels[0].spin_rate, config.initial.yaw_rate
    momentum = yaw_inertia * yaw_rate + gyro
    root = np.sqrt(yaw_inertia * (SIX.axle * spin_rate**2 + yaw_inertia * yaw_rate**2))
    sine = np.sqrt((1.0 - (momentum - root) / gyro) / 2) * np.sin(np.pi * (np.arange(64) + 0.5) / 64)
    speed = np.sqrt(gyro * (1.0 - sine**2) * (root + momentum - gyro * (1.0 - 2.0 * sine**2)) / 2)
    half = np.pi * np.mean(np.sqrt(SIX.axle * yaw_inertia) / speed)
    found = times_of(run, "exchange")
    expected = half * np.arange(1, int(run.time[-1] / half) + 1)
    return Comparison(worst(found, expected), 1e-9, f"periods of the pendulum, {len(expected)} exchanges")


def rocks_by_table(case: Case, run: Trajectory) -> Comparison:
    """A rolling wheel whose torque reverses at every exchange crosses the edge at just these times."""
    expected = np.arange(1, len(times_of(run, "exchange")) + 1) * SWING
    crossing = worst(times_of(run, "exchange"), expected) if len(expected) == SWINGS - 1 else np.inf
    return Comparison(crossing, 1e-10, f"closed form, {len(expected)} exchanges")


def turns_on_the_edge(case: Case, run: Trajectory) -> Comparison:
    """phi = w t - tau t^2 / 2 J, which has its maximum on the edge; no roller carries the wheel beyond its end."""
    t = run.time
    expected = SPIN * t - BRAKE / SIX.axle * t**2 / 2
    beyond = np.abs(run["wheels/wheel/contact_angle"]).max() - SIX.alpha
    return Comparison(
        max(worst(run["wheels/wheel/spin_angle"], expected), beyond), 1e-12, "closed form, and no roller beyond its end"
    )


def stays_on_the_edge(case: Case, run: Trajectory) -> Comparison:
    """The yaw alone goes on: the rollers' momenta balance about the edge."""
    spin = worst(run["wheels/wheel/spin_angle"], np.full(len(run.time), SIX.alpha))
    return Comparison(max(spin, worst(run["body/yaw"] - run["body/yaw"][0], 1.2 * run.time)), 1e-12, "closed form")


def rolls_for_ever(case: Case, run: Trajectory) -> Comparison:
    """Drive and wrench cancel: speed and spin rate stay, and the slip does not grow."""
    slip = np.abs(run["wheels/wheel/slip_velocity"]).max()
    return Comparison(
        max(slip, 1e-2 * worst(speeds(run), np.tile([0.05, 1.0], (len(run.time), 1)))), 1e-12, "zero slip"
    )


def accelerates(excess: float) -> Callable[[Case, Trajectory], Comparison]:
    """Comparison: a wheel at rest under opposed torque and force stays, or slips under what friction cannot hold, N."""

    def claim(case: Case, run: Trajectory) -> Comparison:
        t = run.time
        expected = np.column_stack([-excess / WHEEL.mass * t, excess * WHEEL.radius / WHEEL.axle * t])
        return Comparison(worst(speeds(run), expected), 1e-11, "closed form" if excess else "rest")

    return claim


def rolls_under_the_table(case: Case, run: Trajectory) -> Comparison:
    """V = V_0 + R / (J + M R^2) times the integral of the torque, while the contact sticks."""
    held = np.clip(run.time[:, None] - JUMPS[:-1], 0.0, np.diff(JUMPS))
    spin_rate = 10.0 + held @ TORQUES / (WHEEL.axle + WHEEL.mass * WHEEL.radius**2)
    return Comparison(
        worst(speeds(run), spin_rate[:, None] * [WHEEL.radius, 1.0]), 1e-10, f"closed form, {len(TORQUES)} jumps"
    )


def slip_reverses(case: Case, run: Trajectory) -> Comparison:
    """Friction brakes a sliding wheel until the drive has turned the slip around, and pushes it from there on."""
    pull = 2.0 * WHEEL.limit * WHEEL.rolling  # of the torque on the slip
    turn = 0.5 / (pull + WHEEL.limit * WHEEL.rolling)
    impulse = WHEEL.limit * (np.abs(run.time - turn) - turn)
    spin_rate = (PULL * run.time - WHEEL.radius * impulse) / WHEEL.axle
    expected = np.column_stack([0.5 + impulse / WHEEL.mass, spin_rate])
    return Comparison(worst(speeds(run), expected), 1e-9, "closed form")


def slides_freely(case: Case, run: Trajectory) -> Comparison:
    """Without friction the centre moves straight on and the torque spins the wheel alone."""
    drive = 0.01 if "drive" in "".join(case.overrides) else 0.0
    t = run.time
    straight = worst(run["body/velocity"][:, :2], np.tile([0.5, 0.2], (len(t), 1)))
    return Comparison(
        max(straight, worst(run["wheels/wheel/spin_angle"], 10.0 * t + drive / WHEEL.axle * t**2 / 2)),
        1e-11,
        "closed form",
    )


def lifts_off(case: Case, run: Trajectory) -> Comparison:
    """The wheel leaves the floor when the force equals the weight."""
    return Comparison(worst(times_of(run, "lift_off"), [1.0 / 3.0]), 1e-12, "closed form of the time")


def sticks_on_the_edge(case: Case, run: Trajectory) -> Comparison:
    """Spun up on the spot, the wheel ends its slip just when it passes an edge, and rolls from there on."""
    speed = WHEEL.limit / WHEEL.mass * SPUN
    rolling = worst(speeds(run)[-1], [speed, speed / WHEEL.radius])
    times = worst(times_of(run, "stick"), [SPUN]) + np.abs(times_of(run, "exchange") - SPUN).min()
    return Comparison(max(rolling, times), 1e-8, "closed form")


def exchanges_on_rows(case: Case, run: Trajectory) -> Comparison:
    """Every row stands on an exchange, the last one on the last step, and shows the roller that takes over."""
    exchanges = worst(times_of(run, "exchange"), run.time[1:])
    rollers = worst(run["wheels/wheel/contact_roller"], np.arange(len(run.time)) % 8)
    angle = worst(run["wheels/wheel/contact_angle"], np.full(len(run.time), WHEEL.alpha))
    return Comparison(max(exchanges, rollers, angle), 1e-12, "closed form of times and rollers")


def names_the_step(case: Case, run: Trajectory) -> Comparison:
    """The refusal names a step, and with half of it the run goes through and agrees with the implicit method."""
    named = float(re.search(r"time.step < (\S+) s", run.attributes["status"])[1])
    end = omnisim.load(case.scene, case.overrides).config.time.end
    good = case.run(f"time.step={float(end / np.ceil(2.0 * end / named))!r}")
    implicit = case.run("solver.method=radau5", f"time.step={end / 100!r}")
    return Comparison(apart(good, implicit), 1e-9, "radau5, with half the step that it names")
