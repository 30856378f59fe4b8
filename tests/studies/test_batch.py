"""Runs of a batch share what does not vary between them; each is the run that it would be alone."""

import math
import random

import numpy as np
import pytest

import omnisim
from omnisim.base.keeping import MOST, UNKNOWN, Common, alone, kept
from omnisim.run.marching import Start, packed, packed_once
from omnisim.scene.problems import ConfigError
from omnisim.scene.scene import changed, packaged_scenes
from omnisim.scene.validation import checked
from omnisim.studies.study import Study, load_study
from omnisim.studies.task import Task

DRAWS = 4  # of each scene
SHORT = {"time.step": 1e-3, "time.end": 0.05, "time.output_interval": 0.01}
MEASURES = {
    "far": {"dataset": "body/position", "at": "end", "component": "norm"},
    "slip": {"dataset": "wheels/*/slip_velocity", "reduce": "max", "component": "norm"},
    "load": {"dataset": "wheels/*/normal_force", "reduce": "ptp"},
    "sideways": {"dataset": "body/acceleration", "reduce": "rms", "component": "y"},
    "work": {"dataset": "energy/drive_work", "at": 0.02},
}


def variety(name: str) -> dict:
    """Keys of everything that a scene has, with values that are possible, and a few that are not."""
    config = omnisim.load(name).config
    kind_name, kind = next(iter(config.wheel_types.items()))
    first = config.wheels[0].name
    step = config.time.step or 1e-3
    vary = {
        "time.step": [step, step / 2, 1.37 * step],
        "scene.gravity": {"uniform": [3.0, 12.0]},
        "floor.slope_deg": {"uniform": [0.0, 9.0]},
        "friction.coefficient": {"uniform": [-0.05, 0.9]},
        "solver.tracking": ["explicit", "implicit"],
        "solver.method": ["rk4", "radau5", "auto"],
        "initial": [{"velocity": [0.1, 0.2]}, {"yaw_rate": 0.3}],
        "initial.yaw_deg": {"uniform": [-90.0, 90.0]},
        "wrench": [{"times": [0.0], "force": [[1.0, 0.0, 0.0]]}, {"times": [0.0, 0.1]}],
        f"wheel_types.{kind_name}.radius": {"uniform": [kind.radius, 1.02 * kind.radius]},
        f"wheel_types.{kind_name}.roller_count": [kind.roller_count, kind.roller_count + 1],
        f"wheel_types.{kind_name}.roller.bearing_torque": [0.0, 1e-5],
        f"wheels.{first}.type": [kind_name, "nothing"],
        f"wheels.{first}.drive": [{"kind": "free"}, {"kind": "torque", "torque": 0.2}, {"kind": "rate"}],
        "wheels.*.phase_deg": {"uniform": [0.0, 40.0], "each": True},
        "wheels.*.heading_deg": {"uniform": [0.0, 3.0]},
        "wheels.*.mirrored": [True, False],
        "wheels.*.spin_rate": {"uniform": [-2.0, 2.0]},
        "wheels.*.roller_rates": [0.5, [0.1] * kind.rollers],
    }
    if config.chassis is not None:
        vary |= {
            "chassis.mass": {"mean": config.chassis.mass, "deviation": 0.7 * config.chassis.mass},
            "chassis.center_of_mass": [[0.0, 0.0, 0.05], [0.3, 0.2, 0.1], [0.01, 0.02, 0.05]],
            "chassis.inertia": [[1.0, 1.0, 1.0], [1.0, 1.0, 3.0]],
        }
    return vary


def study_of(name: str, seed: int, **more: object) -> Study:
    """Two runs of this scene with up to four keys varied, drawn by chance."""
    vary, chance = variety(name), random.Random(f"{name} {seed}")
    keys = sorted(chance.sample(sorted(vary), chance.randint(1, 4)))
    design = {"kind": "random", "count": 2, "seed": seed}
    return load_study({"schema": 1, "scene": name, "vary": {key: vary[key] for key in keys}, "design": design, **more})


def bits(value: object) -> list:
    """Everything in arrays, records and NamedTuples of such, as bytes."""
    if isinstance(value, tuple):
        return [bits(part) for part in value]
    return [] if value is None else [np.shape(value), np.asarray(value).tobytes()]


def bits_of(start: Start) -> list:
    """The same of what a scene begins with; nothing stands in `trial` yet."""
    return [bits(start.parameters), bits(start.run._replace(trial=None))]


def outcome(config_of, ask=alone) -> object:
    """What a scene begins with, to the last bit, or what is wrong with it."""
    try:
        return bits_of(packed(config_of(), ask))
    except ConfigError as error:
        return error.problems


@pytest.mark.parametrize("name", packaged_scenes())
def test_a_scene_that_shares_tables_with_others_begins_as_if_it_were_alone(name):
    possible = 0
    for seed in range(DRAWS):
        study = study_of(name, seed, measure={"far": MEASURES["far"]})
        for run in (1, 0, 1):
            shared = outcome(lambda study=study, run=run: study.checked(run), study.variants.complete)
            by_itself = outcome(lambda study=study, run=run: checked(study.data(run)))  # all of its tables are its own
            assert shared == by_itself, (study.config.vary, run)
            possible += isinstance(shared, list)
    assert possible >= 3  # of 12: else nothing is compared


def test_a_scene_that_runs_again_begins_as_it_is_packed_whatever_runs_before_have_written():
    config = omnisim.load("youbot", {"title": "run by nobody else"}).config
    wanted = bits_of(packed(config))
    for _ in range(4):
        start = packed_once(config)
        assert bits_of(start) == wanted
        start.parameters.inputs[:], start.run.y[:], start.run.clock["step"] = 7.0, 7.0, 7
        start.parameters.machine["mass"] = 7.0


@pytest.mark.parametrize(
    "vary",
    [
        {"friction.coefficient": {"uniform": [0.1, 0.9]}, "wheels.*.phase_deg": {"uniform": [0.0, 40.0], "each": True}},
        {"chassis.mass": {"mean": 20.0, "deviation": 15.0}, "wheels.*.spin_rate": {"uniform": [-2.0, 2.0]}},
        {"initial.velocity": [[0.1, 0.0], [0.0, 0.3]], "wheels.front_left.mirrored": [True, False]},
        {"time.step": [1e-3, 2e-3, 3e-4], "scene.gravity": {"uniform": [3.0, 12.0]}},
    ],
)
def test_a_batch_equals_single_runs_to_the_last_bit(vary):
    count = 8
    task = Task(
        load_study(
            {
                "schema": 1,
                "scene": "youbot",
                "set": SHORT,
                "vary": vary,
                "design": {"kind": "random", "count": count, "seed": 3},
                "measure": MEASURES,
            }
        )
    )
    order = [5, 0, 7, 2, 1, 6, 3, 4]
    rows = {row.run: row for row in [*task(order[:5]), *task(order[5:])]}
    complete = 0
    for run in range(count):
        try:
            alone = omnisim.simulate(changed(task.study.scene, task.overrides(run)))
        except omnisim.SceneError as error:
            said = rows[run].status.removeprefix("impossible: ")
            assert said != rows[run].status and said in str(error)
            continue
        assert (rows[run].status, rows[run].stop_time) == (alone.attributes["status"], alone.attributes["stop_time"])
        if alone.complete:
            config = task.study.checked(run)
            assert rows[run].measures == tuple(reading.of(alone, config) for reading in task.readings)
            complete += 1
    assert complete >= 3


def test_what_is_kept_is_told_of_the_very_same_object_only():
    calls = []

    @kept
    def doubled(numbers):
        calls.append(1)
        return [2.0 * number for number in numbers]

    same = (1.0, -0.0)
    assert doubled(same) is doubled(same) and len(calls) == 1
    assert str(doubled((1.0, 0.0))) == "[2.0, 0.0]"  # though 0.0 equals -0.0
    for i in range(3 * MOST):  # objects that go, and whose places in memory others take
        assert doubled((float(i), 0.5)) == [2.0 * i, 1.0]
    assert doubled(same) == [2.0, -0.0]


LOOKS = {
    "adds": lambda numbers: numbers[1] + 1.0,
    "compares": lambda numbers: numbers[1] == 1.0,
    "asks what it is": lambda numbers: isinstance(numbers[1], float),
    "asks whether it is zero": lambda numbers: bool(numbers[1]),
    "rounds": lambda numbers: math.floor(numbers[1]),
    "makes an array of it": lambda numbers: np.array(numbers),
    "puts it into an array": lambda numbers: np.zeros(2).__setitem__(slice(None), numbers),
    "writes it": lambda numbers: f"{numbers[1]}",
    "looks it up": lambda numbers: {1.0: 2.0}.get(numbers[1]),
    "hands it on": lambda numbers: [numbers[1]],
    "hands it on deep within": lambda numbers: {"all": (numbers, 3)},
    "stores it as an object": lambda numbers: np.array(numbers, dtype=object),
}


@pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)
def test_what_looks_at_an_unknown_value_is_found_for_every_variant(look):
    common = Common((2.0, UNKNOWN))
    for value in (1.0, 5.0):
        assert repr(common(look, (2.0, value))) == repr(look((2.0, value)))


def test_what_does_not_look_is_found_once():
    calls = []

    def first(numbers):
        calls.append(numbers)
        return [numbers[0] + 1.0, numbers[1] is None]

    common = Common((2.0, UNKNOWN))
    assert common(first, (2.0, 7.0)) is common(first, (2.0, 8.0))
    assert common(first, (2.0, 9.0)) == [3.0, False] and len(calls) == 1


def test_runs_that_differ_in_numbers_pack_only_what_follows_from_those():
    vary = {"friction.coefficient": {"uniform": [0.1, 0.9]}, "wheels.*.phase_deg": {"uniform": [0, 40], "each": True}}
    study = load_study({"schema": 1, "scene": "youbot", "vary": vary, "design": {"kind": "random", "count": 2}})
    ask = study.variants.complete
    first, second = (packed(study.checked(run), ask).parameters for run in range(2))
    assert first.inputs is second.inputs and first.sector is second.sector
    assert first.machine.friction != second.machine.friction and first.wheels[0].phase != second.wheels[0].phase
    assert not np.shares_memory(first.workspace.contacts, second.workspace.contacts)
