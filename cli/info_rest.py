"""What `omnisim info` tells of a machine at rest, and of one free in space: its pose, how it swings, its rollers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from .screen import BAD_INPUT, Failure

if TYPE_CHECKING:
    import numpy as np

    from omnisim.dynamics.parameters import Parameters
    from omnisim.march.spatial_start import Pose
    from omnisim.scene.scene import Scene
    from omnisim.scene.schema import Config
    from omnisim.scene.wheel_schema import WheelType

ROUND = 1e-9  # of its radius: what a wheel may go up and down by and be round


class Rest(NamedTuple):
    """The machine at rest where it begins: load of each wheel, N, and travel of its suspension, m, None where it has
    none; and what else is told of a machine free in space."""

    loads: np.ndarray | tuple[()]
    travels: Sequence[float | None]
    facts: dict[str, str]


def rest_of(scene: Scene, parameters: Parameters) -> Rest:
    """Raises Failure for a machine free in space that cannot begin where its scene puts it."""
    from omnisim.dynamics.static_loads import static_loads
    from omnisim.march.spatial_start import pose_at_start, standing_pose
    from omnisim.scene.problems import ConfigError

    config = scene.config
    loads = static_loads(parameters, yaw=math.radians(config.initial.yaw_deg))
    if parameters.space is None:
        return Rest(loads, (), {})
    try:
        begins = pose_at_start(config, parameters)
    except ConfigError as error:
        raise Failure(scene.document.told(error.problems), BAD_INPUT) from None
    facts = swing_facts(parameters)
    if config.initial.placed:
        facts = {"it begins": f"as the scene puts it: {pose_told(begins)}"} | facts
    try:
        pose, found = standing_pose(config, parameters)
    except ConfigError:
        return Rest((), (), {"chassis origin": "it has no pose at rest where the scene puts it"} | facts)
    facts = {"chassis origin": pose_told(pose)} | rocker_facts(config, pose) | facts
    springs = [wheel.suspension is not None for wheel in config.wheels]
    travels = [float(pose.carriers[sum(springs[:w])]) if own else None for w, own in enumerate(springs)]
    return Rest(found, travels if any(springs) else (), facts)


def pose_told(pose: Pose) -> str:
    pitch, roll = (round(math.degrees(angle), 9) + 0.0 for angle in (pose.pitch, pose.roll))
    return f"{1e3 * pose.height:.4g} mm over the base plane, pitch {pitch:.3g} deg, roll {roll:.3g} deg"


def rocker_facts(config: Config, pose: Pose) -> dict[str, str]:
    """How far rockers are turned."""
    angles = pose.carriers[len(pose.carriers) - len(config.axles) :]
    return {
        f"rocker '{axle.name}'": f"turned by {math.degrees(angle):.3g} deg about {axle.about}"
        for axle, angle in zip(config.axles, angles, strict=True)
    }


def swing_facts(parameters: Parameters) -> dict[str, str]:
    """How the machine swings on its rubber and springs."""
    from omnisim.dynamics.spatial.swings import swings

    told: dict[str, list[str]] = {}
    for swing in swings(parameters):
        told.setdefault(swing.name, []).append(f"{swing.frequency:.3g} Hz, damped {swing.damping:.0%} of critical")
    return {f"{name} swings": "; ".join(dict.fromkeys(each)) for name, each in told.items()}


def shape_facts(kind: WheelType) -> dict[str, str]:
    """Of rollers with rubber: their shape, what a wheel does where one takes over from the next, and the rubber."""
    from omnisim.scene.rollers import end_radius, half_length, rolling, thickest

    assert kind.contact is not None
    rises, found = "the wheel stays round: both carry it there", rolling(kind)
    if found.highest - found.lowest > ROUND * kind.radius:
        rises = f"between two the wheel goes up and down by {1e3 * (found.highest - found.lowest):.3g} mm"
    half, middle, end = half_length(kind), thickest(kind), end_radius(kind)
    rows = "" if kind.spread else ", in each row"
    return {
        "roller length": f"{2.0 * half:.6g} m",
        "roller radius": f"{middle:.6g} m amid, {end:.6g} m at the ends",
        "exchange": f"every {360.0 / (kind.rollers if kind.spread else kind.roller_count):g} deg{rows}; {rises}",
        "rubber": f"{kind.contact.stiffness:g} N/m, {kind.contact.damping:g} N s/m at each roller that touches",
    }


def jumps(kind: WheelType, wheel: np.record) -> str:
    """How far the contact goes along the axle where the next roller takes over: along its tilt, and to its row."""
    ring = [row.offset for row in kind.rings]
    tilt = 2.0 * wheel.roller_distance * math.tan(wheel.alpha) * wheel.tan_psi
    found = [abs(tilt + there - here) for here, there in zip(ring, ring[1:] + ring[:1], strict=True)]
    return " or ".join(dict.fromkeys(f"{jump:.6g} m" for jump in found)) + " sideways"
