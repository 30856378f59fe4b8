"""Masses, moments of inertia and a centre of mass that a scene leaves out, from the shapes that it gives.

Everything behind `validate` sees a complete scene. `model_fields_set` of a table still tells what the file gives, and
that always wins; the text of the scene stays as it is.

    roller    rho V of the profile's solid with its bore; inertias of that solid, at the roller's mass
    disk      cylinder of radius r and width w: m r^2 / 2 about the axle, I_axle / 2 + m w^2 / 12 about a diameter
    chassis   box a, b, c: m (b^2 + c^2) / 12 about x, and so on; its middle is the centre of mass
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, TypeVar

from omnisim.scene.masses import clearance
from omnisim.scene.problems import Problem, allowed_at
from omnisim.scene.rules import DECIMAL_TOLERANCE
from omnisim.scene.schema import Chassis, Config, Disk, Roller, WheelType
from omnisim.scene.toml_text import KeyPath
from omnisim.scene.values import Table

AnyTable = TypeVar("AnyTable", bound=Table)


class Estimate(NamedTuple):
    """A number that the scene leaves out: its key, its value with its unit, and what it is that of."""

    path: KeyPath
    value: str
    of: str


def shape_rules(config: Config) -> Iterator[Problem]:
    """Every number that is left out has a shape that gives it, and a bore leaves some of its roller."""
    for name, kind in config.wheel_types.items():
        path = ("wheel_types", name)
        yield from _needed((*path, "disk"), kind.disk, {"inertia_axle": "hub_radius", "inertia_diameter": "width"})
        yield from _needed((*path, "roller"), kind.roller, {"mass": "density"})
        thickest = kind.radius - kind.roller_distance
        if kind.roller.bore_radius >= thickest * (1 - DECIMAL_TOLERANCE) > 0.0:
            allowed = f"less than radius - roller_distance = {thickest:.12g}, the roller's own radius amid"
            yield Problem((*path, "roller", "bore_radius"), f"must be {allowed}")
    if config.chassis is not None:
        yield from _needed(("chassis",), config.chassis, {"center_of_mass": "size", "inertia": "size"})


def _needed(path: KeyPath, table: Table, shapes: Mapping[str, str]) -> Iterator[Problem]:
    """shapes: of each key the one that stands for it."""
    for key, shape in shapes.items():
        if not {key, shape} & table.model_fields_set:
            instead = f"or left out beside {shape} ({allowed_at((*path, shape))}), which gives an estimate"
            yield Problem((*path, key), f"missing; must be {allowed_at((*path, key))}, {instead}")


def complete(config: Config) -> Config:
    """The same scene with a number wherever a shape stands for one."""
    kinds = {name: _complete_type(kind) for name, kind in config.wheel_types.items()}
    chassis = config.chassis
    if chassis is not None and _left_out(chassis, "center_of_mass", "inertia"):
        chassis = _filled(chassis, **_box(chassis, clearance(config, chassis)))
    if chassis is config.chassis and all(kind is config.wheel_types[name] for name, kind in kinds.items()):
        return config
    return config.model_copy(update={"wheel_types": kinds, "chassis": chassis})


def estimates(config: Config) -> Iterator[Estimate]:
    """What `complete` found for this scene, which is complete."""
    for name, kind in config.wheel_types.items():
        path = ("wheel_types", name)
        roller = kind.roller
        disk = kind.disk
        bore = f" with a bore of radius {roller.bore_radius:g} m" if roller.bore_radius else ""
        for key in _left_out(roller, "mass", "inertia_axial", "inertia_transverse"):
            unit, much = ("kg", f"{roller.density:g} kg/m^3") if key == "mass" else ("kg m^2", f"{roller.mass:.4g} kg")
            value = f"{getattr(roller, key):.5g} {unit}"
            yield Estimate((*path, "roller", key), value, f"the profile's solid{bore}, {much}")
        for key in _left_out(disk, "inertia_axle", "inertia_diameter"):
            shape = f"radius {disk.hub_radius:g} m" if key == "inertia_axle" else f"{disk.width:g} m wide"
            value = f"{getattr(disk, key):.5g} kg m^2"
            yield Estimate((*path, "disk", key), value, f"a cylinder, {shape}, {disk.mass:g} kg")
    if config.chassis is not None:
        size = " x ".join(f"{side:g}" for side in config.chassis.size)
        for key in _left_out(config.chassis, "center_of_mass", "inertia"):
            numbers = ", ".join(f"{number:.5g}" for number in getattr(config.chassis, key))
            above = f", {clearance(config, config.chassis):g} m above the floor"
            unit, where = ("m", above) if key == "center_of_mass" else ("kg m^2", f", {config.chassis.mass:g} kg")
            yield Estimate(("chassis", key), f"[{numbers}] {unit}", f"a box of {size} m{where}")


def _left_out(table: Table, *keys: str) -> list[str]:
    return [key for key in keys if key not in table.model_fields_set]


def _filled(table: AnyTable, **estimated: Any) -> AnyTable:
    """The table with estimates where it has nothing; its `model_fields_set` stays."""
    new = {key: value for key, value in estimated.items() if key not in table.model_fields_set}
    if not new:
        return table
    values = {name: getattr(table, name) for name in type(table).model_fields}
    return type(table).model_construct(_fields_set=table.model_fields_set, **(values | new))


def _complete_type(kind: WheelType) -> WheelType:
    roller, disk = kind.roller, kind.disk
    if _left_out(roller, "mass", "inertia_axial", "inertia_transverse"):
        roller = _filled(roller, **_solid(kind, roller))
    if _left_out(disk, "inertia_axle", "inertia_diameter"):
        disk = _filled(disk, inertia_axle=0.5 * disk.mass * disk.hub_radius**2)
        disk = _filled(disk, inertia_diameter=_across(disk))
    given = roller is kind.roller and disk is kind.disk
    return kind if given else kind.model_copy(update={"roller": roller, "disk": disk})


def _solid(kind: WheelType, roller: Roller) -> dict[str, float]:
    from omnisim.scene.solids import outline, solid  # here: NumPy is slow to import, and few scenes need it

    volume, axial, transverse = solid(outline(kind), roller.bore_radius)
    mass = roller.mass or roller.density * volume
    return {"mass": mass, "inertia_axial": mass * axial / volume, "inertia_transverse": mass * transverse / volume}


def _across(disk: Disk) -> float:
    return 0.5 * disk.inertia_axle + disk.mass * disk.width**2 / 12.0


def _box(chassis: Chassis, clearance: float) -> dict[str, tuple[float, float, float]]:
    a, b, c = (side**2 for side in chassis.size)
    inertia = chassis.mass * (b + c) / 12.0, chassis.mass * (a + c) / 12.0, chassis.mass * (a + b) / 12.0
    return {"center_of_mass": (0.0, 0.0, clearance + 0.5 * chassis.size[2]), "inertia": inertia}
