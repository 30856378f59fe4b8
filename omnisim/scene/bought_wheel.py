"""A packaged wheel under a robot: what a data sheet would say of it, and what its scene asks of the robot's."""

import math
from typing import NamedTuple

from omnisim.scene.design import KINDS, DesignError, short
from omnisim.scene.ideal_kinematics import MECANUM
from omnisim.scene.masses import wheel_mass
from omnisim.scene.packaged import packaged_text, packaged_wheels
from omnisim.scene.problems import did_you_mean
from omnisim.scene.scene import parse
from omnisim.scene.schema import FRICTION_KEYS, Config

STEP = 5e-4  # s, of a robot whose wheels ask for no other


class BoughtWheel(NamedTuple):
    """Its name, what it is, radius (m), mass (kg), the kinds of robots that it is for; tables that they need, step (s),
    law of friction with its keys but the coefficient, and that."""

    name: str
    told: str
    radius: float
    mass: float
    kinds: tuple[str, ...]
    tables: str
    step: float
    law: tuple[str, ...]
    coefficient: float


def bought_wheel(name: str) -> BoughtWheel:
    """The packaged wheel of this name. Raises DesignError."""
    known = packaged_wheels()
    if name not in known:
        hint = did_you_mean(name, known) or f"; must be one of {', '.join(known)}"
        raise DesignError(f"{name}: no packaged wheel has this name{hint}")
    config = parse(packaged_text(name), name).config
    kind, friction = config.wheel_types[name], config.friction
    mecanum = abs(math.radians(kind.roller_angle_deg)) >= MECANUM
    law = [f'law = "{friction.law}"']
    law += [f"{key} = {short(getattr(friction, key))}" for key in FRICTION_KEYS[friction.law] if key != "coefficient"]
    free = config.upright == "free"
    return BoughtWheel(
        name,
        config.title,
        kind.radius,
        wheel_mass(kind),
        tuple(robot for robot, made in KINDS.items() if (made.psi_deg != 0.0) == mecanum),
        free_tables(config) if free else "",
        config.time.step if free and config.time.step else STEP,
        tuple(law),
        friction.coefficient,
    )


def free_tables(config: Config) -> str:
    """Of robots whose wheels stand on rubber."""
    return f"""
[scene]
upright = "free" # its rollers are not the exact ones: they stand on rubber

[solver]
method = "{config.solver.method}"
"""
