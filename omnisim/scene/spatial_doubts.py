"""What a scene of a machine free in space says that is hardly meant: of rollers, rubber, springs, step and height."""

import math
from collections.abc import Iterator

import numpy as np

from omnisim.base.methods import IMPLICIT, METHODS
from omnisim.scene.heights import heights_of
from omnisim.scene.masses import point_masses, share_of_weight
from omnisim.scene.problems import Problem
from omnisim.scene.rollers import rolling
from omnisim.scene.schema import Config, Wheel
from omnisim.scene.toml_text import KeyPath

BESIDE = 0.01  # of the radius of a wheel, off what its rollers make it
MOST_SAG = 1e-3  # m, of rubber under its share of the weight
HIGH = 2.0  # wheel radii, above the highest ground
SHARING = 2.0  # rollers that carry a wheel where one takes over from the next


def wrong_radius(config: Config) -> Iterator[Problem]:
    """A wheel whose rollers, if they are not cut for it, carry it on another radius than the scene gives."""
    for name, kind in config.wheel_types.items():
        if kind.profile.kind == "exact":
            continue
        found = rolling(kind)
        if not found.lowest - BESIDE * kind.radius <= kind.radius <= found.highest + BESIDE * kind.radius:
            what = (
                f"its rollers carry it on {found.lowest:.4g} to {found.highest:.4g} m, by roller_distance and profile"
            )
            yield Problem(
                ("wheel_types", name, "radius"), f"{what}; expected about {found.mean:.4g} m, or other rollers"
            )


def soft_rubber(config: Config) -> Iterator[Problem]:
    """Rubber that sags by more than a millimetre: rollers are rigid in it, and no longer where they seem."""
    if config.upright != "free":
        return
    load = share_of_weight(config)
    for name, kind in used_types(config).items():
        assert kind.contact is not None
        sag = load / kind.contact.stiffness
        if sag > MOST_SAG:
            what = f"it sags by {1e3 * sag:.3g} mm under {load:.3g} N, a wheel's share of the weight"
            expected = f"at least {load / MOST_SAG:.2g} N/m"
            yield Problem(("wheel_types", name, "contact", "stiffness"), f"{what}; expected {expected}")


def soft_springs(config: Config) -> Iterator[Problem]:
    """Suspensions that are pressed in, or out, by more than the radius of their wheel."""
    if config.upright != "free":
        return
    load = share_of_weight(config)
    for index, wheel in enumerate(config.wheels):
        spring, radius = wheel.suspension, config.type_of(wheel).radius
        if spring is None:
            continue
        carried = load - spring.mass * config.world.gravity - spring.preload
        if abs(carried) > radius * spring.stiffness:
            path = ("wheels", index, "suspension", "stiffness")
            what = f"{abs(carried):.3g} N beyond its preload press it {'in' if carried > 0.0 else 'out'}"
            expected = f"at least {abs(carried) / radius:.2g} N/m, or another preload"
            yield Problem(path, f"{what} by more than the wheel's radius; expected {expected}")


def fast_rubber(config: Config) -> Iterator[Problem]:
    """Rubber that swings faster, or is damped more, than explicit steps can follow."""
    method = METHODS[config.solver.method]
    step = config.time.step
    if config.upright != "free" or step is None or config.solver.error is not None or method.choice == IMPLICIT:
        return
    limit = method.tableau.stability_limit / step
    fastest: tuple[float, KeyPath] = (0.0, ())
    for wheel in config.wheels:
        contact = config.type_of(wheel).contact
        assert contact is not None
        stiffness, damping = SHARING * contact.stiffness, SHARING * contact.damping
        half = 0.5 * damping / carried_mass(config, wheel)
        square = stiffness / carried_mass(config, wheel)
        rate = half + math.sqrt(half * half - square) if half * half > square else math.sqrt(square)
        key = "damping" if half * half > square else "stiffness"
        fastest = max(fastest, (rate, ("wheel_types", wheel.type, "contact", key)))
    rate, path = fastest
    if rate > limit:
        what = f"it makes wheels swing at about {rate:.2g} 1/s, and {config.solver.method} follows {limit:.2g} 1/s"
        expected = f"time.step < {0.5 * method.tableau.stability_limit / rate:.2g} s, or method = 'radau5'"
        yield Problem(path, f"{what} with time.step = {step:g} s; expected {expected}")


def high_start(config: Config) -> Iterator[Problem]:
    """A machine that begins with a fall."""
    height = config.initial.height
    if config.upright != "free" or height is None or config.world.gravity == 0.0:
        return
    above = height - highest_ground(config)
    radius = max(config.type_of(wheel).radius for wheel in config.wheels)
    if above > HIGH * radius:
        speed = math.sqrt(2.0 * config.world.gravity * above)
        what = f"it falls {above:.3g} m to the ground, and meets it at {speed:.3g} m/s"
        yield Problem(("initial", "height"), f"{what}; expected at most {HIGH * radius:.3g} m over the highest ground")


# --- what they need -------------------------------------------------------------------------------


def used_types(config: Config) -> dict:
    return {wheel.type: config.type_of(wheel) for wheel in config.wheels}


def carried_mass(config: Config, wheel: Wheel) -> float:
    """What moves on the rubber of a wheel, kg: with its hub, or its share of the machine."""
    masses = point_masses(config)[0]
    if wheel.suspension is not None or config.rocker_of(wheel) is not None:
        return masses[config.wheels.index(wheel)]
    return math.fsum(masses) / len(config.wheels)


def highest_ground(config: Config) -> float:
    """Nothing of the floor is above, m."""
    floor = config.floor
    rises = [max(bump[2], 0.0) for bump in floor.bumps] + [max(step.height, 0.0) for step in floor.steps]
    grid = 0.0 if floor.grid is None else float(np.max(heights_of(floor.grid.file)))
    return math.fsum(rises) + max(grid, 0.0)
