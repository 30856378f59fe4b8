"""What the C layer knows of a scene, as a header: sizes, places in the memory, variables, what a status says."""

import json
from collections.abc import Iterable
from typing import Any

from omnisim.base.status import EVENT_KINDS, EVENTS_PER_STEP, LOG_FULL, RUNNING, SAFE_STEP, SENTENCES
from omnisim.dynamics.state import places_in
from omnisim.native.memory import Machine, Memory
from omnisim.native.object_code import Target
from omnisim.native.parameters import Parameter
from omnisim.native.variables import Input, Output, inputs_of, outputs_of
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.schema import Config

CLOCK_FIELDS = ("step", "goal", "row", "steps_per_row", "piece", "events", "status", "wheel", "dt", "rate", "elapsed")
KERNELS = "march", "observe"


class Later:
    """A value of a sentence that only the machine will know: {name} stays there, for machine.c to fill in."""

    def __init__(self, name: str):
        self.name = name

    def __format__(self, _: str) -> str:
        return f"{{{self.name}}}"


def sentences(config: Config, dt: float) -> list[str]:
    """What each status says, of a run of this scene."""
    told = {name: Later(name) for name in ("time", "wheel", "rate", "limit")}
    known = {
        "method": config.solver.method,
        "step": dt,
        "tenth": 0.1 * dt,
        "events": EVENTS_PER_STEP,
    }
    found = [SENTENCES.get(code, "").format_map(told | known) for code in range(max(SENTENCES) + 1)]
    found[RUNNING] = "a bug in omnisim: a kernel has raised an exception"
    return found


def header(
    config: Config, machine: Machine, memory: Memory, parameters: list[Parameter], identity: str, kinds: list[Target]
) -> str:
    """scene.h, which machine.c includes. identity: 16 hexadecimal digits, by which the library knows its states; kinds:
    of processors that there is code for."""
    constants, _, run, _, log = machine.marched
    at = places_in(constants)
    clock = run.clock
    numbers = {
        "LIBRARY": f"UINT64_C(0x{identity})",
        "GRID": float(clock.dt),
        "END": config.time.end,
        "KEPT": memory.kept,
        "SIZE": memory.size,
        "RUNNING": RUNNING,
        "LOG_FULL": LOG_FULL,
        "SAFE_STEP": SAFE_STEP,
        "STABILITY_LIMIT": float(clock.stability_limit),
        "WHEELS": len(config.wheels),
        "CHANNELS": constants.inputs.shape[1],
        "PIECES": len(constants.starts) - 1,
        "PIECES_ROOM": len(constants.starts),
        "EVENT_KINDS": len(EVENT_KINDS),
        "STARTS": memory[constants.starts],
        "INPUTS": memory[constants.inputs],
        "PUSHED": memory.field(constants.machine, "pushed"),
        "LOG": memory[log],
        "EVENT_SIZE": log.dtype.itemsize,
        "EVENT_KIND": log.dtype.fields["kind"][1],
        "SEEN_PIECE": memory[machine.observed[1].piece],
        "SEEN_TIME": memory[machine.observed[2]],
        "Y": memory[run.y],
        "SPIN_ANGLE": at.spin_angle,
        "VELOCITY": at.velocity,
        "YAW_RATE": at.yaw_rate,
        "RATE": at.rate,
        "CENTRE": memory.field(constants.machine, "centre"),
        "ODOMETRY_YAW": memory.field(constants.machine, "odometry_yaw"),
        "WHEEL_SIZE": constants.wheels.dtype.itemsize,
        "WHEEL_ODOMETRY": memory.field(constants.wheels, "odometry", 0),
        "HEIGHT": float(constants.wheels[0].radius) if config.chassis is None else 0.0,
        "FREE": int(constants.space is not None),
        "ORIGIN": 0 if constants.space is None else memory.field(constants.space.body, "origin"),
    }
    numbers |= {f"CLOCK_{name.upper()}": memory.field(clock, name) for name in CLOCK_FIELDS}
    inputs, outputs = inputs_of(config, machine), outputs_of(config, machine, memory)
    followers = [w for w, wheel in enumerate(config.wheels) if wheel.drive.controlled]
    return "\n".join(
        [
            "/* Written by omnisim: what machine.c knows of one scene. Places are bytes in the memory of a machine. */",
            *(f"#define {name} {value}" for name, value in numbers.items()),
            *choice(kinds),
            *array("static const omnisim_variable INPUT[]", map(told, inputs)),
            *array("static const omnisim_variable OUTPUT[]", map(told, outputs)),
            *array("static const int CHANNEL[]", (str(one.channel) for one in inputs)),
            *array("static const struct place PLACE[]", (f"{{{one.found}, {one.place}}}" for one in outputs)),
            *array("static const struct copy COPIED[]", copies(machine, memory)),
            *array("static const char *const SENTENCE[]", map(text, sentences(config, float(clock.dt)))),
            *array("static const char *const WHEEL[]", (text(wheel.name) for wheel in config.wheels)),
            f"#define PARAMETERS {len(parameters)}",
            *array("static const omnisim_variable PARAMETER[]", map(ranged, parameters)),
            f"#define FACTORS {sum(len(one.by) for one in parameters)}",
            *array("static const struct factor FACTOR[]", factors(parameters)),
            f"#define FOLLOWERS {len(followers)}",
            *array("static const struct follower FOLLOWER[]", twists(config, followers, inputs)),
            "",
        ]
    )


def choice(kinds: list[Target]) -> list[str]:
    """The functions for each kind of processor, and CALLED(march) or CALLED(observe), the one for that which is there:
    of the last kind that has all that it needs."""
    declared = [f"int64_t omnisim_{kernel}{kind.level}(unsigned char *memory);" for kind in kinds for kernel in KERNELS]
    called = f"omnisim_##kernel{kinds[0].level}"
    for kind in kinds[1:]:
        there = " && ".join(f"__builtin_cpu_supports({text(feature)})" for feature in kind.needed)
        called = f"({there} ? omnisim_##kernel##{kind.level} : {called})"
    return [*declared, f"#define CALLED(kernel) ({called})"]


def array(declared: str, entries: Iterable[str]) -> list[str]:
    """An array of C; one without entries has a zero, which nobody reads."""
    return [f"{declared} = {{", *(f"    {entry}," for entry in list(entries) or ["{0}"]), "};"]


def text(said: str) -> str:
    """A string of C."""
    return json.dumps(said, ensure_ascii=True)


def told(variable: Input | Output) -> str:
    start = variable.start if isinstance(variable, Input) else 0.0
    whole = int(isinstance(variable, Output) and variable.whole)
    return (
        f"{{{text(variable.name)}, {text(variable.unit)}, {text(variable.description)}, {start!r}, {whole}, 0.0, 0.0}}"
    )


def ranged(parameter: Parameter) -> str:
    name, unit, start, least, most, _ = parameter
    return f"{{{text(name)}, {text(unit)}, {text(parameter.description)}, {start!r}, 0, {least!r}, {most!r}}}"


def factors(parameters: list[Parameter]) -> list[str]:
    """Where each parameter acts, and what it is multiplied with there."""
    return [f"{{{i}, {place}, {by!r}}}" for i, one in enumerate(parameters) for place, by in one.by.items()]


def twists(config: Config, followers: list[int], inputs: list[Input]) -> list[str]:
    """Of each drive that follows a rate: its input, and that rate by the twist of an ideal machine."""
    by_name = {one.name: i for i, one in enumerate(inputs)}
    rows = wheel_rows(config)
    found = []
    for w in followers:
        own = ", ".join(repr(float(value)) for value in rows[w])
        found.append(f"{{{by_name[f'wheels/{config.wheels[w].name}/rate']}, {{{own}}}}}")
    return found


def copies(machine: Machine, memory: Memory) -> list[str]:
    """What is copied before an instant is looked at: its state into a row, and workspace where searches begin."""
    parameters, _, run, *_ = machine.marched
    own, row, *_ = machine.observed
    pairs = [(run.y, row.y), (run.rates, row.rates), (run.mode, row.mode)]
    pairs += zip(leaves(parameters.workspace), leaves(own.workspace), strict=True)
    return [f"{{{memory[source]}, {memory[target]}, {source.nbytes}}}" for source, target in pairs]


def leaves(workspace: Iterable[Any]) -> list[Any]:
    """The arrays in a tuple of such that may be None."""
    return [array for array in workspace if array is not None]
