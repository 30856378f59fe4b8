"""Masses, moments of inertia and a centre of mass that a scene leaves out, from the shapes that it gives.

Everything behind `validate` sees a complete scene. `model_fields_set` of a table still tells what the file gives, and
that always wins; the text of the scene stays as it is.

    roller    rho V of the profile's solid with its bore; inertias of that solid, at the roller's mass
    disk      cylinder of radius r and width w: m r^2 / 2 about the axle, I_axle / 2 + m w^2 / 12 about a diameter;
              with a bore and with plates: see `disk_solid`
    chassis   box a, b, c: m (b^2 + c^2) / 12 about x, and so on; its middle is the centre of mass
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, TypeVar

from omnisim.base.keeping import kept
from omnisim.scene.masses import clearance
from omnisim.scene.problems import Problem, allowed_at
from omnisim.scene.roller_rules import DECIMAL_TOLERANCE
from omnisim.scene.schema import Chassis, Config
from omnisim.scene.toml_text import KeyPath
from omnisim.scene.values import Table
from omnisim.scene.wheel_schema import Disk, Roller, WheelType

AnyTable = TypeVar("AnyTable", bound=Table)


class Estimate(NamedTuple):
    """A number that the scene leaves out: its key, its value with its unit, and what it is that of."""

    path: KeyPath
    value: str
    of: str


def shape_rules(config: Config) -> Iterator[Problem]:
    """Every number that is left out has a shape that gives it, and a bore leaves some of a roller of the exact
    profile; those of others: profile_rules.py."""
    for name, kind in config.wheel_types.items():
        path = ("wheel_types", name)
        yield from _needed((*path, "disk"), kind.disk, {"inertia_axle": "hub_radius", "inertia_diameter": "width"})
        yield from _disk_rules((*path, "disk"), kind.disk)
        yield from _needed((*path, "roller"), kind.roller, {"mass": "density"})
        thickest = kind.radius - kind.roller_distance
        if kind.profile.kind == "exact" and kind.roller.bore_radius >= thickest * (1 - DECIMAL_TOLERANCE) > 0.0:
            allowed = f"less than radius - roller_distance = {thickest:.12g}, the roller's own radius amid"
            yield Problem((*path, "roller", "bore_radius"), f"must be {allowed}")
    if config.chassis is not None:
        yield from _needed(("chassis",), config.chassis, {"center_of_mass": "size", "inertia": "size"})


def _disk_rules(path: KeyPath, disk: Disk) -> Iterator[Problem]:
    """A bore leaves some of the hub, and plates stand around its ends."""
    if disk.hub_radius and disk.bore_radius >= disk.hub_radius:
        yield Problem((*path, "bore_radius"), f"must be less than hub_radius = {disk.hub_radius:g}")
    plates = {"plate_radius", "plate_thickness"}
    if missing := (plates | {"hub_radius", "width"}) - disk.model_fields_set if plates & disk.model_fields_set else ():
        key = min(missing)
        yield Problem((*path, key), f"missing; with plates it must be {allowed_at((*path, key))}")
    elif disk.plate_radius and disk.plate_radius <= disk.hub_radius:
        yield Problem((*path, "plate_radius"), f"must be more than hub_radius = {disk.hub_radius:g}")
    elif 2.0 * disk.plate_thickness > disk.width > 0.0:
        yield Problem((*path, "plate_thickness"), f"must be at most width / 2 = {0.5 * disk.width:g}, at each end")


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
            yield Estimate((*path, "disk", key), value, f"a cylinder, {shape}{_more(disk)}, {disk.mass:g} kg")
    if config.chassis is not None:
        size = " x ".join(f"{side:g}" for side in config.chassis.size)
        for key in _left_out(config.chassis, "center_of_mass", "inertia"):
            numbers = ", ".join(f"{number:.5g}" for number in getattr(config.chassis, key))
            above = f", {clearance(config, config.chassis):g} m above the floor"
            unit, where = ("m", above) if key == "center_of_mass" else ("kg m^2", f", {config.chassis.mass:g} kg")
            yield Estimate(("chassis", key), f"[{numbers}] {unit}", f"a box of {size} m{where}")


def _more(disk: Disk) -> str:
    bore = f", with a bore of radius {disk.bore_radius:g} m" if disk.bore_radius else ""
    plates = f" and plates of radius {disk.plate_radius:g} m, {disk.plate_thickness:g} m thick"
    return bore + (plates if disk.plate_radius else "")


def varied(config: Config, path: KeyPath, factor: float) -> Config:
    """The same scene, an estimate of it times a factor; other estimates that follow from that one follow."""
    *place, key = map(str, path)
    kind = config.wheel_types[place[1]] if len(place) > 1 else None
    table: Table = config.chassis if kind is None else getattr(kind, place[2])  # type: ignore[assignment]
    values = {name: getattr(table, name) for name in type(table).model_fields}
    found = values[key]
    values[key] = tuple(factor * part for part in found) if isinstance(found, tuple) else factor * found
    given = type(table).model_construct(_fields_set=table.model_fields_set | {key}, **values)
    if kind is None:
        return complete(config.model_copy(update={"chassis": given}))
    kinds = config.wheel_types | {place[1]: kind.model_copy(update={place[2]: given})}
    return complete(config.model_copy(update={"wheel_types": kinds}))


def _left_out(table: Table, *keys: str) -> list[str]:
    return [key for key in keys if key not in table.model_fields_set]


def _filled(table: AnyTable, **estimated: Any) -> AnyTable:
    """The table with estimates where it has nothing; its `model_fields_set` stays."""
    new = {key: value for key, value in estimated.items() if key not in table.model_fields_set}
    if not new:
        return table
    values = {name: getattr(table, name) for name in type(table).model_fields}
    return type(table).model_construct(_fields_set=table.model_fields_set, **(values | new))


@kept
def _complete_type(kind: WheelType) -> WheelType:
    roller, disk = kind.roller, kind.disk
    if _left_out(roller, "mass", "inertia_axial", "inertia_transverse"):
        roller = _filled(roller, **_solid(kind, roller))
    if _left_out(disk, "inertia_axle", "inertia_diameter"):
        disk = _disk(disk)
    given = roller is kind.roller and disk is kind.disk
    return kind if given else kind.model_copy(update={"roller": roller, "disk": disk})


def _solid(kind: WheelType, roller: Roller) -> dict[str, float]:
    from omnisim.scene.rollers import roller_solid  # here: NumPy is slow to import, and few scenes need it

    volume, axial, transverse = roller_solid(kind)
    mass = roller.mass or roller.density * volume
    return {"mass": mass, "inertia_axial": mass * axial / volume, "inertia_transverse": mass * transverse / volume}


def _disk(disk: Disk) -> Disk:
    """With its inertias; that about a diameter follows the one about the axle, given or not."""
    from omnisim.scene.solids import disk_solid

    shape = disk
    if not disk.hub_radius:  # then the axle's is given, there are no plates, and all cylinders of this width are alike
        shape = disk.model_copy(update={"hub_radius": 1.0, "bore_radius": 0.0})
    volume, axle, diameter = disk_solid(shape)
    disk = _filled(disk, inertia_axle=disk.mass * axle / volume)
    return _filled(disk, inertia_diameter=0.5 * disk.inertia_axle + disk.mass * (diameter - 0.5 * axle) / volume)


def _box(chassis: Chassis, clearance: float) -> dict[str, tuple[float, float, float]]:
    a, b, c = (side**2 for side in chassis.size)
    inertia = chassis.mass * (b + c) / 12.0, chassis.mass * (a + c) / 12.0, chassis.mass * (a + b) / 12.0
    return {"center_of_mass": (0.0, 0.0, clearance + 0.5 * chassis.size[2]), "inertia": inertia}
