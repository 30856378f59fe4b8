"""Units of parameters: each number of a scene has one, made of those of SI."""

import math
from typing import get_args, get_origin

import pytest

import omnisim
from omnisim.native.units import DERIVED, GAINS, KEYS, UNITS, base_units, unit_of
from omnisim.scene.schema import Config
from omnisim.scene.values import Table


def numbers(table, path=()):
    """Keys of all numbers of a scene, with the tables that they stand in."""
    for name, field in table.model_fields.items():
        inner = [kind for part in get_args(field.annotation) for kind in (part, *get_args(part))]
        here = (*path, field.alias or name)
        for kind in (field.annotation, *inner):
            if isinstance(kind, type) and issubclass(kind, Table):
                yield from numbers(kind, here)
        if field.annotation is float or (get_origin(field.annotation) is not tuple and float in inner):
            yield here


def test_every_number_of_a_scene_has_a_unit():
    """But those of time and solver, which are no parameters."""
    found = {path for path in numbers(Config) if path[0] not in ("time", "solver")}
    assert len(found) > 60 and {("friction", "coefficient"), ("wheels", "drive", "torque")} < found
    for *_, table, key in found:
        there = key.endswith("_deg") or key in UNITS or f"{table}.{key}" in UNITS
        assert there or key in GAINS["dc_motor"], (table, key)


@pytest.mark.parametrize(
    ("scene", "name", "unit"),
    [
        ("youbot", "wheels.front_left.drive.integral", "N m/rad"),
        ("platform24v", "wheels.front_left.drive.integral", "V/rad"),
        ("platform24v", "wheels.front_left.drive.viscosity", "N m s"),
        ("six_rollers", "friction.viscosity", "N s/m"),
        ("six_rollers", "initial.yaw_deg", "deg"),
        ("six_rollers", "friction.coefficient", "1"),
        ("kiwi", "wheel_types.kiwi_omni.roller.mass", "kg"),
    ],
)
def test_a_number_has_the_unit_of_its_key(scene, name, unit):
    assert unit_of(omnisim.load(scene).config, name) == unit


def test_units_are_made_of_those_of_si():
    """By what they are: 1 V A = 1 W, 1 ohm A = 1 V, 1 H A = 1 V s, 1 N m = 1 J = 1 W s."""

    def product(*units):
        total = {}
        for unit in units:
            for base, power in base_units(unit).items():
                total[base] = total.get(base, 0) + int(power)
        return {base: power for base, power in total.items() if power}

    assert product("V", "A") == product("N m/s") == {"kg": 1, "m": 2, "s": -3}
    assert product("ohm", "A") == product("V")
    assert product("H", "A") == product("V", "s")
    assert product("N m/A") == product("V s")
    assert product("V s^2/rad", "rad") == product("V", "s", "s")
    assert base_units("deg") == {"rad": "1", "factor": repr(math.pi / 180.0)}
    known = {"kg", "m", "s", "A", "rad", *DERIVED}
    assert {word.partition("^")[0] for unit in KEYS for word in unit.replace("/", " ").split()} - {"1"} <= known
