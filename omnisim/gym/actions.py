"""What an action does: what becomes of the scene's drives, and the input of each drive by the action.

torque   each drive is a plain torque, at most its limit
rate     each drive follows a rate with the scene's own controller
twist    the same, with the rates of ideal wheels in a twist of the chassis (ideal_kinematics.py)
"""

import math
import tomllib
from typing import Any, NamedTuple

import numpy as np

from omnisim.scene.drives import standstill_torque
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.scene import Scene, SceneError, parse
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import MISSING, KeyPath, assign, rewrite

TWIST = (1.0, 1.0, 3.0)  # of an action of 1, by default: m/s, m/s, rad/s
RIM_SPEED = 1.0  # m/s
TORQUE_DRIVE = {"kind": "torque", "torque": 0.0}


class Actions(NamedTuple):
    """limits (A,): what an action of 1 means; wheels (D,): those that are driven; inputs (D, A): of their drives by an
    action, before they are scaled."""

    limits: np.ndarray
    wheels: np.ndarray
    inputs: np.ndarray

    def of(self, action: np.ndarray) -> np.ndarray:
        """Inputs (..., D) of the drives, torques (N m) or target rates (rad/s), by actions (..., A) within -1 and 1.

        No product of matrices: it may round by how many there are.
        """
        scaled = np.clip(action, -1.0, 1.0) * self.limits
        return (scaled[..., None, :] * self.inputs).sum(axis=-1)


def actions(scene: Scene, kind: str, limits: tuple[float, ...]) -> Actions:
    """The Actions of one kind on a scene as its author wrote it. Raises SceneError where its drives do not take them,
    ValueError for limits of another number."""
    config = scene.config
    if config.upright == "free":
        raise SceneError(f'{scene.source}: scene.upright = "free": environments take machines that are held upright')
    wheels = np.array([w for w, wheel in enumerate(config.wheels) if wheel.drive.given is not None], int)
    if not len(wheels):
        raise SceneError(f"{scene.source}: wheels: none has a drive that takes an input")
    inputs = np.eye(len(wheels))
    if kind != "torque":
        others = [wheel.name for wheel in config.wheels if wheel.drive.given and not wheel.drive.controlled]
        if others:
            raise SceneError(
                f"{scene.source}: wheels.{others[0]}.drive: must follow a rate where actions are a {kind}: "
                'kind "rate", or "dc_motor" with proportional; or action = "torque"'
            )
    if kind == "twist":
        if config.chassis is None:
            raise SceneError(f'{scene.source}: chassis: missing; a twist needs one; or action = "rate"')
        inputs = wheel_rows(config)[wheels]
    count = inputs.shape[1]
    if len(limits) not in (0, 1, count):
        raise ValueError(f"option limits: must be 1 or {count} numbers for actions of kind {kind}, not {len(limits)}")
    return Actions(np.broadcast_to(limits or default_limits(scene, kind, wheels), count), wheels, inputs)


def default_limits(scene: Scene, kind: str, wheels: np.ndarray) -> tuple[float, ...]:
    if kind == "twist":
        return TWIST
    config = scene.config
    driven = [config.wheels[w] for w in wheels]
    if kind == "rate":
        return tuple(RIM_SPEED / config.type_of(wheel).radius for wheel in driven)
    torques = tuple(standstill_torque(wheel.drive) for wheel in driven)
    for wheel, torque in zip(driven, torques, strict=True):
        if not 0.0 < torque < math.inf:
            raise SceneError(
                f"{scene.source}: wheels.{wheel.name}.drive: tells no largest torque; give the option limits"
            )
    return torques


def prepared(scene: Scene, kind: str, duration: float) -> Scene:
    """The scene with drives that wait for actions, and a time that is the path's, without rows in between.

    Raises SceneError for a wrench over time, which does not go with inputs over time.
    """
    if len(scene.config.wrench.table[0]) > 1:
        raise SceneError(f"{scene.source}: wrench.times: must be absent; an environment takes a constant wrench")
    data = tomllib.loads(scene.text)
    edits: list[tuple[KeyPath, Any]] = [(("time", "end"), duration), (("time", "output_interval"), duration)]
    if "command" in data:
        edits.append((("command",), MISSING))
    for w, wheel in enumerate(scene.config.wheels):
        if wheel.drive.given is None:
            continue
        if kind == "torque":
            edits.append((("wheels", w, "drive"), TORQUE_DRIVE))
            continue
        edits.append((("wheels", w, "drive", "rate"), 0.0))
        if "times" in data["wheels"][w]["drive"]:
            edits.append((("wheels", w, "drive", "times"), MISSING))
    for path, value in edits:
        assign(data, path, value)
    return parse(rewrite(scene.text, edits, data), scene.source)


def held_by(config: Config, interval: float) -> int:
    """Steps of the scene for which an action is held. Raises ValueError if that is no whole number."""
    step = config.time.step or interval  # a Loop has made sure that there is one
    steps = round(interval / step)
    if steps < 1 or abs(steps * step - interval) > 1e-9 * interval:
        raise ValueError(f"option control: 1 / {1.0 / interval:g} s must be a multiple of time.step = {step:g} s")
    return steps
