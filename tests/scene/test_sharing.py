"""Tables that say the same are one object, which nobody can tell but by `is`."""

import gc
import math
import tomllib
from weakref import ref

import pytest
from vehicles import FOLLOWING, VEHICLE

import omnisim
from omnisim.base.keeping import MOST
from omnisim.scene import sharing
from omnisim.scene.problems import ConfigError
from omnisim.scene.scene import SceneError, packaged_scenes, parse
from omnisim.scene.toml_text import assign
from omnisim.scene.validation import checked, tuples, validate

pytestmark = pytest.mark.short
SCENES = {"vehicle": VEHICLE, "cable_duct": omnisim.load("cable_duct").text, "rocker": omnisim.load("rocker").text}


def tables(value: object, path: tuple = ()) -> list:
    """Every table in data, with its path."""
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    below = [found for key, entry in entries for found in tables(entry, (*path, key))]
    return [(path, value), *below] if isinstance(value, dict) else below


def outcome(made, data: dict) -> object:
    """All that a scene says, and which of its keys are given; or what is wrong with it."""
    try:
        config = made(data)
    except ConfigError as error:
        return error.problems
    return repr(config), repr(config.model_dump(exclude_unset=True))


def unshared(data: dict) -> object:
    """A scene all of whose tables are its own."""
    return checked(tuples(data))


def message(text: str, *overrides: str) -> str:
    with pytest.raises(SceneError) as error:
        parse(text, "s.toml", overrides)
    return str(error.value)


def test_scenes_that_say_the_same_are_one():
    assert parse(VEHICLE).config is parse(f"# a comment\n{VEHICLE}", "another.toml").config
    assert parse(VEHICLE, overrides=["chassis.mass=7"]).config is parse(VEHICLE, overrides=["chassis.mass=7"]).config


@pytest.mark.parametrize("name", packaged_scenes())
def test_a_scene_that_is_loaded_again_is_the_first_with_all_that_was_estimated(name):
    assert omnisim.load(name).config is omnisim.load(name).config


def test_a_number_that_changes_leaves_all_tables_beside_it_the_same():
    first, other = (parse(FOLLOWING, overrides={"wheels.fl.drive.proportional": value}).config for value in (0.5, 0.6))
    assert (first.wheels[0].drive.proportional, other.wheels[0].drive.proportional) == (0.5, 0.6)
    assert all(a is b for a, b in zip(other.wheels[1:], first.wheels[1:], strict=True))
    assert other.chassis is first.chassis and other.command is first.command
    assert other.wheel_types["mecanum"] is first.wheel_types["mecanum"]


def test_a_wheel_has_the_drive_of_another_before_that_says_the_same():
    drive = {"kind": "torque", "torque": 0.25}
    first, other = (parse(VEHICLE, overrides={f"wheels.{name}.drive": drive}).config for name in ("fl", "rr"))
    assert first.wheels[0].drive is other.wheels[3].drive


@pytest.mark.parametrize("first", [0.0, -0.0])
def test_zero_keeps_its_sign_whatever_was_there_before(first):
    for zero in (first, -first, first):
        initial = parse(VEHICLE, overrides={"initial.yaw_rate": zero}).config.initial
        assert math.copysign(1.0, initial.yaw_rate) == math.copysign(1.0, zero)


def test_what_equals_a_number_is_not_taken_for_it():
    for _ in range(2):
        for value in (1.0, 1):
            mass = parse(VEHICLE, overrides={"chassis.mass": value}).config.chassis.mass
            assert (type(mass), mass) == (float, 1.0)
        assert "chassis.mass = true: must be a finite number > 0" in message(VEHICLE, "chassis.mass=true")
        assert "chassis.mass = '1.0': must be a finite number > 0" in message(VEHICLE, "chassis.mass='1.0'")
        parse(VEHICLE, overrides={"wheels.fl.mirrored": True})
        assert "mirrored = 1: must be true or false" in message(VEHICLE, "wheels.fl.mirrored=1")
        assert "schema = true: must be 1" in message(VEHICLE, "schema=true")
        assert "schema = 1.0: must be 1" in message(VEHICLE, "schema=1.0")


@pytest.mark.parametrize("text", SCENES.values(), ids=SCENES)
def test_a_table_is_taken_only_where_it_is_right(text):
    """Every table at the place of every other, and a list of it: all are known, and each is told as if none were."""
    parse(text)
    known = tables(tomllib.loads(text))
    refused = 0
    for path, _ in known[1:]:
        for _, table in known:
            for value in (table, [table], [[table]]):
                data = tomllib.loads(text)
                assign(data, path, value)
                found = outcome(validate, data)
                assert found == outcome(unshared, data), (path, value)
                refused += isinstance(found[0], tuple)
    assert refused > 2 * len(known) ** 2  # of three times as many: else nothing is out of place


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("mass = 6.0", "mass = true", "chassis.mass = true: must be a finite number > 0"),
        ("mass = 6.0", "mass = 6.0\nmas = 4.0", "chassis.mas = 4.0: unknown key; did you mean 'mass'?"),
        ("[scene]", "[scene]\ngravity = -1.0", "scene.gravity = -1.0: must be a finite number >= 0"),
    ],
)
def test_what_is_wrong_is_told_again_with_its_line(old, new, said):
    assert VEHICLE.count(old) == 1
    text = VEHICLE.replace(old, new)
    line = 1 + text[: text.index(new.splitlines()[-1])].count("\n")
    first = message(text)
    assert first.startswith(f"s.toml:{line}: {said}")
    parse(VEHICLE)
    assert message(text) == message(text) == first


def test_rules_across_keys_are_told_again():
    broken = "wheels.fl.drive={kind = 'free', torque = 1.0}", "wheels.rr.drive={kind = 'free', torque = 1.0}"
    first = message(VEHICLE, *broken)
    assert "wheels.fl.drive.torque" in first and "wheels.rr.drive.torque" in first
    assert message(VEHICLE, *broken) == first
    assert message(VEHICLE, *reversed(broken)) == first
    alone = message(VEHICLE, broken[1])  # whose table was that of both
    assert "wheels.rr.drive.torque" in alone and "wheels.fl" not in alone


def test_nothing_is_known_of_tables_that_nobody_holds():
    data = tuples(tomllib.loads(VEHICLE) | {"title": "held by nobody"})
    data["chassis"] = data["chassis"] | {"mass": 5.4321}
    config = sharing.modelled(data)
    assert sharing.modelled(data) is config
    whole, chassis, known = ref(config), ref(config.chassis), len(sharing._known)
    del config
    gc.collect()
    assert whole() is None and chassis() is None
    assert len(sharing._known) <= known - 2


def test_scenes_in_great_number_are_forgotten():
    """Functions hold up to 64 of them each, and forget all at once: how many are known goes up and down."""
    before = len(sharing._known)
    seen = [ref(parse(VEHICLE, overrides={"chassis.mass": 5.0 + 1e-6 * i}).config) for i in range(4 * MOST)]
    gc.collect()
    assert sum(config() is not None for config in seen) <= 2 * MOST
    assert len(sharing._known) - before <= 4 * MOST  # a scene and its chassis, twice: of 8 MOST
