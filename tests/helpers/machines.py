"""Machines for tests: scenes as dictionaries to change, their mirror images, and random ones."""

import json
import tomllib

import numpy as np

import omnisim
from omnisim.scene.scene import Scene, parse

TYPES = {
    "mecanum": {
        "radius": 0.0475, "roller_distance": 0.036, "roller_count": 6, "roller_angle_deg": 45.0,
        "disk": {"mass": 0.4, "inertia_axle": 4.2e-4, "inertia_diameter": 2.4e-4},
        "roller": {"mass": 0.05, "inertia_axial": 3.1e-6, "inertia_transverse": 1.2e-5},
    },
    "omni": {
        "radius": 0.0625, "roller_distance": 0.053, "roller_count": 10, "roller_angle_deg": 0.0,
        "disk": {"mass": 0.3, "inertia_axle": 3.75e-4, "inertia_diameter": 2.1e-4},
        "roller": {"mass": 0.02, "inertia_axial": 7.6e-7, "inertia_transverse": 2.4e-6},
    },
}  # fmt: skip


def tables(source: Scene | str) -> dict:
    """A scene, or the packaged one of this name, as a dictionary."""
    return tomllib.loads((omnisim.load(source) if isinstance(source, str) else source).text)


LOCKED = 1e4  # kg m^2
BOX = ((0.2, 0.15), (0.2, -0.15), (-0.2, 0.15), (-0.2, -0.15))  # front left, front right, rear left, rear right
CHASSIS = {"mass": 6.0, "center_of_mass": [0.0, 0.0, 0.1], "inertia": [0.1, 0.2, 0.25]}


def machine(kind: str, places=BOX, headings_deg=(), drives=(), **changed) -> dict:
    """A machine on wheels w0, w1, ... of one of TYPES without friction; mecanum wheels alternate as in a BOX."""
    wheels = [{"name": f"w{i}", "type": kind, "position": list(place)} for i, place in enumerate(places)]
    for key, values in (("heading_deg", headings_deg), ("drive", drives)):
        for wheel, value in zip(wheels, values, strict=False):
            wheel[key] = value
    if kind == "mecanum":
        for wheel in wheels:
            wheel["mirrored"] = wheel["position"][0] * wheel["position"][1] < 0.0
    return {
        "schema": 1,
        "time": {"end": 1.0, "step": 1e-3, "output_interval": 0.01},
        "friction": {"law": "none"},
        "wheel_types": {kind: TYPES[kind]},
        "chassis": CHASSIS,
        "wheels": wheels,
    } | changed


def axle_inertia(kind: str) -> float:
    """J_k of a wheel of one of TYPES, kg m^2."""
    wheel, sine = TYPES[kind], np.sin(np.radians(TYPES[kind]["roller_angle_deg"]))
    roller = wheel["roller"]
    ring = roller["mass"] * wheel["roller_distance"] ** 2 + roller["inertia_transverse"] * (1.0 - sine**2)
    return wheel["disk"]["inertia_axle"] + wheel["roller_count"] * ring


def diameter_inertia(kind: str) -> float:
    """J_t of a wheel of one of TYPES, kg m^2."""
    wheel, cosine = TYPES[kind], np.cos(np.radians(TYPES[kind]["roller_angle_deg"]))
    roller = wheel["roller"]
    ring = roller["mass"] * wheel["roller_distance"] ** 2 / 2 + roller["inertia_transverse"] * (1.0 - cosine**2 / 2)
    return wheel["disk"]["inertia_diameter"] + wheel["roller_count"] * ring


def wheel_mass(kind: str) -> float:
    wheel = TYPES[kind]
    return wheel["disk"]["mass"] + wheel["roller_count"] * wheel["roller"]["mass"]


def scene(data: dict, *overrides: str) -> Scene:
    return parse("\n".join(f"{key} = {toml(value)}" for key, value in data.items()), overrides=overrides)


def toml(value) -> str:
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(float(value)) if isinstance(value, float) else json.dumps(value)


def run(data: dict, *overrides: str):
    """Trajectory of a scene that must reach its end."""
    trajectory = omnisim.simulate(scene(data, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


def on_slope(data: dict, slope: float, uphill_deg: float = 0.0) -> dict:
    """The scene on a slope of so many rad."""
    return data | {"floor": {"slope_deg": float(np.degrees(slope)), "uphill_deg": uphill_deg}}


def locked(data: dict, rotor: float = LOCKED) -> dict:
    """The scene with wheels that hardly turn: each has a rotor of so many kg m^2, and no voltage on it."""
    data = json.loads(json.dumps(data))
    data.pop("command", None)
    for wheel in data["wheels"]:
        wheel["drive"] = {"kind": "dc_motor", "voltage": 0.0, "resistance": 1.0, "torque_constant": 1e-9,
                          "rotor_inertia": rotor}  # fmt: skip
    return data


def mirrored(data: dict) -> dict:
    """The scene seen in a mirror that stands along the x axis of the world.

    Rolling forward stays rolling forward; a rate about a roller's axis changes its sign, as does one about the normal.
    """
    data = json.loads(json.dumps(data))
    for wheel in data["wheels"]:
        x, y = wheel["position"]
        wheel["position"] = [x, -y]
        wheel["heading_deg"] = -wheel.get("heading_deg", 0.0)
        wheel["mirrored"] = not wheel.get("mirrored", False)
        wheel["roller_rates"] = (-np.array(wheel.get("roller_rates", 0.0))).tolist()
    for kind in data["wheel_types"].values():
        for row in kind.get("rows", []):
            row["offset"] = -row["offset"]
    x, y, z = data["chassis"]["center_of_mass"]
    data["chassis"]["center_of_mass"] = [x, -y, z]
    initial = data.setdefault("initial", {})
    for key in {"yaw_deg", "yaw_rate", "roll_deg", "roll_rate"} & set(initial):
        initial[key] = -initial[key]
    for key in {"position", "velocity"} & set(initial):
        initial[key] = [initial[key][0], -initial[key][1]]
    if "floor" in data:
        floor = data["floor"]
        floor["uphill_deg"] = -floor.get("uphill_deg", 0.0)
        if "bumps" in floor:
            floor["bumps"] = [[x, -y, *shape] for x, y, *shape in floor["bumps"]]
    if "command" in data:
        data["command"]["twist"] = [[vx, -vy, -yaw_rate] for vx, vy, yaw_rate in data["command"]["twist"]]
    if "wrench" in data:
        data["wrench"]["force"] = [[x, -y, z] for x, y, z in data["wrench"].get("force", [])]
        data["wrench"]["yaw_torque"] = [-torque for torque in data["wrench"].get("yaw_torque", [])]
    return data


def rotated(data: dict, angle_deg: float) -> dict:
    """The same machine after a turn of the world about the origin."""
    data = json.loads(json.dumps(data))
    turn = rotation(np.radians(angle_deg))
    if "floor" in data:
        floor = data["floor"]
        floor["uphill_deg"] = floor.get("uphill_deg", 0.0) + angle_deg
        if "bumps" in floor:
            floor["bumps"] = [[*(turn @ bump[:2]).tolist(), *bump[2:]] for bump in floor["bumps"]]
    initial = data.setdefault("initial", {})
    initial["yaw_deg"] = initial.get("yaw_deg", 0.0) + angle_deg
    for key in {"position", "velocity"} & set(initial):
        initial[key] = (turn @ initial[key]).tolist()
    if "wrench" in data and data["wrench"].get("frame", "world") == "world":
        data["wrench"]["force"] = [[*(turn @ force[:2]).tolist(), force[2]] for force in data["wrench"]["force"]]
    return data


def rotation(angle: float) -> np.ndarray:
    """Matrix (2, 2) that turns by `angle` (rad)."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
