"""Wheels side by side: each under the same platform, which drives through the same cycle.

Four wheels carry the platform, at the corners of a square. Mecanum wheels all head forward, and the axes of the rollers
that touch point to the middle; omni wheels roll around it. Controllers turn them as an ideal machine would, so what is
found is the wheels' own: what their rollers shake, lose and leave out. Friction, rubber, methods and steps are those of
the scene that a wheel comes from; a motion that these do not carry to its end has another try by each of CURES.
"""

import math
import tomllib
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from omnisim.results.layout import COMPLETE
from omnisim.results.trajectory import Trajectory
from omnisim.scene.ideal_kinematics import MECANUM
from omnisim.scene.masses import point_masses, wheel_mass
from omnisim.scene.scene import Scene, load_text
from omnisim.scene.toml_text import write_value
from omnisim.studies.many import simulate_many

MASS = 20.0  # kg, of the platform with its wheels, where no scene has a machine
SPEED = 0.5  # m/s
RAMP, STEADY, END = 0.5, 1.0, 3.0  # s: how long it speeds up, from when on it is measured, and until when
ROWS = 2e-3  # s between them, about
CORNER, WIDE = 0.15, 2.0  # m, of a wheel from the middle along x and y; at least so many of its radii
SETTLING, RESETTING = 0.02, 0.1  # s, of the controllers
HALF = math.sqrt(0.5)
CYCLE = {
    "forward": (1.0, 0.0, 0.0),
    "sideways": (0.0, 1.0, 0.0),
    "diagonal": (HALF, HALF, 0.0),
    "turning": (0.0, 0.0, 1.0),
}  # directions of the velocity along x, along y, and of the wheels' centres around the middle
CORNERS = (("front_left", 1, 1), ("front_right", 1, -1), ("rear_left", -1, 1), ("rear_right", -1, -1))
CURES = (("radau5", 1e-3), ("radau5", 2e-4))  # methods and their steps, s
LOSSES = ("friction", "bearing", "rolling", "contact", "damper")


class Candidate(NamedTuple):
    """A type of wheels of a scene."""

    name: str
    scene: Scene
    kind: str


class Found(NamedTuple):
    """Of a wheel in one motion of the cycle, while that is steady.

    speed   what the platform is faster than the ideal machine, 1
    ripple  root mean square of its velocity about the mean, m/s: of its middle, and that of a wheel by the yaw rate
    height  between its lowest and its highest, m; None if it is held upright
    drag    what is lost by the way, J/m = N
    energy  what the drives give by the way, J/m; what they take back when they brake does not count
    load    largest normal force of a wheel, of its share of the weight, 1
    cure    method and step (s), where those of the scene have not carried it to its end
    """

    speed: float
    ripple: float
    height: float | None
    drag: float
    energy: float
    load: float
    cure: tuple[str, float] | None = None


def candidates(scenes: Sequence[Scene]) -> list[Candidate]:
    """All types of wheels that these scenes use."""
    found = []
    for scene in scenes:
        kinds = list(dict.fromkeys(wheel.type for wheel in scene.config.wheels))
        found += [Candidate(scene.name if len(kinds) == 1 else f"{scene.name}:{kind}", scene, kind) for kind in kinds]
    return found


def usual_mass(wheels: Sequence[Candidate]) -> float:
    """Of the first machine among them, kg."""
    for wheel in wheels:
        if wheel.scene.config.chassis is not None:
            return float(math.fsum(point_masses(wheel.scene.config)[0]))
    return MASS


def compare_wheels(wheels: Sequence[Candidate], mass: float, speed: float = SPEED) -> list[dict[str, Found | str]]:
    """Of each wheel the motions of CYCLE by name: what is Found, or the sentence with which the run stopped.

    mass: of the platform, kg; speed: of the wheels' centres, m/s. Raises SceneError, and ValueError for a platform that
    is lighter than its wheels.
    """
    carriages = [Platform(wheel, mass, speed) for wheel in wheels]
    tasks = [(carriage, motion) for carriage in carriages for motion in CYCLE]
    found = driven(tasks, None)
    for cure in CURES:
        stopped = [i for i, entry in enumerate(found) if isinstance(entry, str)]
        for i, entry in zip(stopped, driven([tasks[i] for i in stopped], cure), strict=True):
            found[i] = entry if isinstance(entry, Found) else found[i]
    rows = iter(found)
    return [{motion: next(rows) for motion in CYCLE} for _ in carriages]


def driven(tasks: Sequence[tuple["Platform", str]], cure: tuple[str, float] | None) -> list[Found | str]:
    """What is found of platforms in these motions."""
    runs = simulate_many([load_text(platform.scene(motion, cure)) for platform, motion in tasks])
    found = [platform.found(run, motion) for (platform, motion), run in zip(tasks, runs, strict=True)]
    return [entry if isinstance(entry, str) else entry._replace(cure=cure) for entry in found]


class Platform:
    """What four wheels of a Candidate carry. Raises ValueError if it is lighter than they are."""

    def __init__(self, wheel: Candidate, mass: float, speed: float):
        self.wheel, self.mass, self.speed = wheel, mass, speed
        self.kind = wheel.scene.config.wheel_types[wheel.kind]
        self.corner = max(CORNER, WIDE * self.kind.radius)  # of the wheels along x, and along y, m
        self.arm = math.hypot(self.corner, self.corner)
        self.chassis = mass - 4.0 * wheel_mass(self.kind)
        if self.chassis <= 0.0:
            raise ValueError(f"four wheels of {wheel.name} weigh more than the platform of {mass:g} kg; see --mass")

    def scene(self, motion: str, cure: tuple[str, float] | None = None) -> str:
        """The scene of one motion, as TOML; cure: another method and step (s) than the wheel's own."""
        data, radius = tomllib.loads(self.wheel.scene.text), self.kind.radius
        gain = self.mass / 4.0 * radius**2 / SETTLING
        drive = {"kind": "rate", "proportional": gain, "integral": gain / RESETTING}
        twist = [self.speed * part for part in CYCLE[motion]]
        twist[2] /= self.arm
        own: dict[str, Any] = {key: data[key] for key in ("scene", "solver", "friction") if key in data}
        if own.get("scene", {}).get("upright") == "servo":
            del own["scene"]["upright"]
        span = times(self.wheel.scene)
        if cure:
            own["solver"] = {"method": cure[0]}
            span = stepped(cure[1])
        keys: dict[str, Any] = {
            "schema": 1,
            "title": f"{self.wheel.name} {motion}",
            **own,
            "time": span,
            "wheel_types": {self.wheel.kind: data["wheel_types"][self.wheel.kind]},
            "chassis": {
                "mass": self.chassis,
                "size": [2.0 * self.corner, 2.0 * self.corner, radius],
                "ground_clearance": 0.5 * radius,
            },
            "wheels": [place | {"type": self.wheel.kind, "drive": drive} for place in self.places()],
            "command": {"times": [0.0, RAMP], "twist": [[0.0, 0.0, 0.0], twist]},
        }
        return "\n".join(f"{key} = {write_value(value)}" for key, value in keys.items())

    def places(self) -> Iterator[dict[str, Any]]:
        """Names, positions and headings of the wheels."""
        angle = math.radians(self.kind.roller_angle_deg)
        for name, x, y in CORNERS:
            turned: dict[str, Any] = {"heading_deg": math.degrees(math.atan2(x, -y))}
            if abs(angle) >= MECANUM:
                turned = {"mirrored": (x * y < 0) != (angle < 0.0)}
            yield {"name": name, "position": [x * self.corner, y * self.corner]} | turned

    def found(self, run: Trajectory, motion: str) -> Found | str:
        """What a run of this motion has shown."""
        if run.attributes["status"] != COMPLETE:
            return str(run.attributes["status"])
        steady = run.time >= STEADY
        velocity = self.velocity(run)[:, steady]
        mean = velocity.mean(axis=1)
        along = float(mean @ CYCLE[motion])
        way = along * (run.time[-1] - run.time[steady][0])
        lost = sum(grown(run, path, steady) for path in (f"energy/{name}_loss" for name in LOSSES) if path in run)
        load = max(run[f"interval_max/wheels/{name}/normal_force"][steady].max() for name in run.wheels)
        return Found(
            along / self.speed - 1.0,
            float(np.sqrt(((velocity - mean[:, None]) ** 2).sum(axis=0).mean())),
            float(np.ptp(run["body/position"][steady, 2])) if "energy/elastic" in run else None,
            float(lost) / way,
            self.given(run, steady) / way,
            float(load) / (self.mass * self.wheel.scene.config.world.gravity / 4.0),
        )

    def given(self, run: Trajectory, steady: np.ndarray) -> float:
        """Work of the drives while they do not brake, J, by the trapezoidal rule over rows."""
        power = sum(np.maximum(run[f"wheels/{name}/drive_power"][steady], 0.0) for name in run.wheels)
        return float(np.trapezoid(power, run.time[steady]))

    def velocity(self, run: Trajectory) -> np.ndarray:
        """Of the platform's middle along its axes, and of a wheel's centre around it, m/s (3, T)."""
        yaw = run["body/yaw"]
        v_x, v_y, _ = run["body/velocity"].T
        ahead, aside = v_x * np.cos(yaw) + v_y * np.sin(yaw), v_y * np.cos(yaw) - v_x * np.sin(yaw)
        return np.array([ahead, aside, self.arm * run["body/yaw_rate"]])


def times(scene: Scene) -> dict[str, float]:
    """[time] of the platform: with the step of a scene, or with none if that is picked for an error."""
    step = scene.config.time.step
    if step is None or scene.config.solver.error is not None:
        return {"end": END, "output_interval": ROWS}
    return stepped(step)


def stepped(step: float) -> dict[str, float]:
    """[time] with this step, s."""
    interval = step * max(1, round(ROWS / step))
    return {"end": interval * round(END / interval), "step": step, "output_interval": interval}


def grown(run: Trajectory, path: str, steady: np.ndarray) -> float:
    """By how much an integral has grown."""
    values = run[path][steady]
    return float(values[-1] - values[0])
