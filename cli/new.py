"""`omnisim new`: a first scene of a robot, from a few numbers that its data sheet has."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .screen import BAD_INPUT, Failure, note

if TYPE_CHECKING:
    from omnisim.scene.design import Robot

INCH, POUND, GRAVITY = 0.0254, 0.45359237, 9.80665
ENDLESS = 1e9  # in SI units: what no machine has
UNITS = {
    "m": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": INCH},
    "kg": {"kg": 1.0, "g": 1e-3, "lb": POUND},
    "N m": {"Nm": 1.0, "mNm": 1e-3, "Ncm": 1e-2, "kgcm": 1e-2 * GRAVITY, "ozin": POUND / 16.0 * GRAVITY * INCH},
    "rad/s": {"rad/s": 1.0, "rpm": 0.10471975511965977},
    "m/s": {"m/s": 1.0},
    "A": {"A": 1.0, "mA": 1e-3},
    "V": {"V": 1.0},
    "": {"": 1.0},
}


class Quantity(click.ParamType):
    """A number > 0 with or without a unit: 0.076, "76 mm", "3 in"; without one it is SI."""

    def __init__(self, unit: str):
        self.unit = unit
        self.name = unit or "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        found = re.fullmatch(r"\s*([-+.\deE]*)\s*(.*?)\s*", str(value))
        number, unit = found.groups() if found else ("", "")
        scale = UNITS[self.unit].get(re.sub(r"[\s.*]", "", unit) or self.unit.replace(" ", ""), 0.0)
        try:
            result = float(number) * scale
        except ValueError:
            result = 0.0
        if not 0.0 < result < ENDLESS:
            known = f" with a unit or none: {', '.join(UNITS[self.unit])}" if self.unit else ""
            self.fail(f"{value!r}: must be a number > 0{known}", param, ctx)
        return result


# Option, what it is, its unit, and what it is by default (by kind where that differs).
QUESTIONS: dict[str, tuple[str, str, Any]] = {
    "wheel_radius": ("Radius of a wheel", "m", {"mecanum": "76 mm", "kiwi": "50 mm", "four-omni": "30 mm"}),
    "track": (
        "Track, from a left wheel to a right one",
        "m",
        {"mecanum": "300 mm", "four-omni": "130 mm"},
    ),
    "wheelbase": ("Wheelbase, from a rear wheel to a front one", "m", {"mecanum": "350 mm", "four-omni": "130 mm"}),
    "distance": ("Distance of a wheel from the middle of the machine", "m", {"kiwi": "150 mm"}),
    "mass": ("Mass of the whole robot", "kg", {"mecanum": "12 kg", "kiwi": "3 kg", "four-omni": "2.5 kg"}),
    "torque": ("Largest torque at a wheel", "N m", {"mecanum": "2 N m", "kiwi": "1 N m", "four-omni": "0.3 N m"}),
    "voltage": ("Nominal voltage", "V", "24 V"),
    "stall_torque": ("Stall torque of the motor, before its gear", "N m", "0.35 N m"),
    "stall_current": ("Stall current", "A", "12 A"),
    "no_load_speed": ("No-load speed of the motor, before its gear", "rad/s", "7500 rpm"),
    "no_load_current": ("No-load current", "A", "0.3 A"),
    "gear": ("Gear ratio, motor to wheel", "", "20"),
}
OF_WHEEL = ("rollers", "roller_diameter", "wheel_mass")
PLACES = {"mecanum": ("track", "wheelbase"), "four-omni": ("track", "wheelbase"), "kiwi": ("distance",)}
MOTORS = {
    "rate": ("torque",),
    "dc_motor": ("stall_torque", "stall_current", "no_load_speed", "no_load_current", "voltage", "gear"),
}


def asked(name: str):
    text, unit, _ = QUESTIONS[name]
    return click.option(f"--{name.replace('_', '-')}", type=Quantity(unit), help=f"{text}.")


def all_asked(command):
    for name in reversed(QUESTIONS):
        command = asked(name)(command)
    return command


@click.command()
@click.argument("file", default="robot.toml")
@click.option("--kind", type=click.Choice(tuple(PLACES)), help="Four mecanum, three omni or four omni wheels.")
@all_asked
@click.option("--motor", type=click.Choice(tuple(MOTORS)), help="A controller with a largest torque, or a data sheet.")
@click.option("--wheel", metavar="NAME", help="A wheel that is sold: omnisim data lists them.")
@click.option("--rollers", type=click.IntRange(4, 100), help="Rollers of one wheel; else estimated.")
@click.option("--roller-diameter", type=Quantity("m"), help="Of a roller amid; else estimated.")
@click.option("--wheel-mass", type=Quantity("kg"), help="One wheel with its rollers; else estimated.")
@click.option("--size", type=Quantity("m"), nargs=3, help="Length, width and height of the chassis; else estimated.")
@click.option("--friction", type=Quantity(""), help="Coefficient on the floor; else estimated.")
@click.option("--speed", type=Quantity("m/s"), help="Of the square that it drives.")
@click.option("--side", type=Quantity("m"), default="1 m", help="Of the square that it drives; else 1 m.")
@click.option("--yes", is_flag=True, help="Ask nothing: take defaults for what is not given.")
@click.option("--force", is_flag=True, help="Replace a file that exists.")
def new(file: str, force: bool, yes: bool, **given: Any) -> None:
    """Write a first scene of a robot to FILE (robot.toml), from a few numbers that its data sheet has.

    It asks for what is not given. Numbers are SI or have a unit: 0.076, "76 mm", "7500 rpm", "15 kg cm". What a data
    sheet does not say is estimated, and marked so in the scene. The robot drives a square.

    \b
    omnisim new                                   asks
    omnisim new kit.toml --yes                    a mecanum platform of 12 kg, to change in the editor
    omnisim new arm.toml --kind kiwi --wheel-radius 50mm --distance 15cm --mass 3 --torque "10 kg cm"
    omnisim new desk.toml --wheel lekiwi_omni_102   a robot on wheels that are sold
    """
    from omnisim.scene.scene import SceneError, parse

    from .output import deliver, output_path

    if Path(file).suffix != ".toml":
        raise Failure(f"{file}: a scene is a TOML file; choose a name that ends in .toml", BAD_INPUT)
    path = output_path(file, "", force)
    robot, told = answered(given, yes)
    text = written(robot, f"omnisim new {shlex.join(told)}")
    try:
        doubts = list(parse(text, file).warnings)
    except SceneError as error:
        doubts = str(error).splitlines()
    if doubts:
        without_place = (doubt.split(": ", 2)[1:] for doubt in reversed(doubts))  # a line of no file
        once = {said: f"{key}: {said}" for key, said in without_place}  # what is wrong with all wheels, of the first
        wrong = "\n".join(reversed(once.values()))
        raise Failure(f"these numbers make no machine; nothing was written\n{wrong}", BAD_INPUT)
    deliver({path: text.encode()}, force)
    click.echo(path)
    note(f"next: omnisim info {path}; omnisim run {path}; omnisim view {path.stem}.h5 --open")


def written(robot: Robot, command: str) -> str:
    from omnisim.scene.design import DesignError
    from omnisim.scene.first_scene import scene_text

    try:
        return scene_text(robot, command)
    except DesignError as error:
        raise Failure(str(error), BAD_INPUT) from None


def answered(given: dict[str, Any], yes: bool) -> tuple[Robot, list[str]]:
    """The robot, by options, answers and defaults; and the options that would say all of it."""
    from omnisim.scene.design import Controller, Motor, Robot

    motor_kind = meant("motor", given, MOTORS)  # before the first question: what cannot be is said at once
    places = PLACES
    if given["wheel"]:
        places = on_wheels(given)
    elif not yes and given["wheel_radius"] is None:
        note("wheels that are sold: --wheel NAME, of `omnisim data`")
    kind = meant("kind", given, places) or choose("kind", "Kind of machine", given, places, yes)
    answers = {name: answer(name, given, kind, yes) for name in ("wheel_radius", *PLACES[kind], "mass")}
    question = "Motors: rate (a controller with a largest torque) or dc_motor (by a data sheet)"
    motor_kind = motor_kind or choose("motor", question, given, MOTORS, yes)
    by_motor = {name: answer(name, given, kind, yes) for name in MOTORS[motor_kind]}
    motor = Controller(**by_motor) if motor_kind == "rate" else Motor(*by_motor.values())
    rest = {name: given[name] for name in (*OF_WHEEL, "size", "friction", "speed", "wheel")}
    robot = Robot(kind, motor=motor, side=given["side"], **answers, **rest)
    told = answers | by_motor | rest | {"side": given["side"]}
    if robot.wheel:
        del told["wheel_radius"]
    return robot, ["--kind", kind, *options({name: value for name, value in told.items() if value is not None})]


def on_wheels(given: dict[str, Any]) -> dict[str, tuple[str, ...]]:
    """The kinds of machines that the packaged wheel is for, which gives its radius; Failure for what it settles."""
    from omnisim.scene.bought_wheel import bought_wheel
    from omnisim.scene.design import DesignError

    try:
        wheel = bought_wheel(given["wheel"])
    except DesignError as error:
        raise Failure(f"--wheel {error}", BAD_INPUT) from None
    for name in ("wheel_radius", *OF_WHEEL):
        if given[name] is not None:
            raise Failure(f"--{name.replace('_', '-')}: --wheel {wheel.name} has its own", BAD_INPUT)
    if given["kind"] and given["kind"] not in wheel.kinds:
        known = ", ".join(wheel.kinds)
        raise Failure(f"--kind {given['kind']}: not of --wheel {wheel.name}, which is for {known}", BAD_INPUT)
    given["wheel_radius"] = wheel.radius
    return {kind: names for kind, names in PLACES.items() if kind in wheel.kinds}


def options(answers: dict[str, Any]) -> Iterator[str]:
    for name, value in answers.items():
        yield f"--{name.replace('_', '-')}"
        parts = value if isinstance(value, tuple) else (value,)
        yield from (part if isinstance(part, str) else f"{part:.9g}" for part in parts)


def meant(what: str, given: dict[str, Any], choices: dict[str, tuple[str, ...]]) -> str | None:
    """The choice that is given, or the only one that has an option given; Failure for options of another choice."""
    having = [choice for choice, names in choices.items() if any(given[name] is not None for name in names)]
    choice = given[what] or (having[0] if len(having) == 1 else None)
    if choice:
        refuse_others(what, given, choices, choice)
    return choice


def choose(what: str, question: str, given: dict[str, Any], choices: dict[str, tuple[str, ...]], yes: bool) -> str:
    """By a question, of which the first choice is the default."""
    choice = ask(what, question, click.Choice(tuple(choices)), next(iter(choices)), yes)
    refuse_others(what, given, choices, choice)
    return choice


def refuse_others(what: str, given: dict[str, Any], choices: dict[str, tuple[str, ...]], choice: str) -> None:
    for name in sorted({name for names in choices.values() for name in names} - set(choices[choice])):
        if given[name] is not None:
            has = ", ".join(f"--{known.replace('_', '-')}" for known in choices[choice])
            raise Failure(f"--{name.replace('_', '-')}: not of --{what} {choice}, which has {has}", BAD_INPUT)


def answer(name: str, given: dict[str, Any], kind: str, yes: bool) -> Any:
    if given[name] is not None:
        return given[name]
    text, unit, default = QUESTIONS[name]
    return ask(name, text, Quantity(unit), default[kind] if isinstance(default, dict) else default, yes)


def ask(name: str, text: str, kind: click.ParamType, default: str, yes: bool) -> Any:
    """On stderr, until the answer is a good one."""
    if yes:
        return kind.convert(default, None, None)
    try:
        return click.prompt(text, default=default, type=kind, err=True)
    except click.Abort:
        option = f"--{name.replace('_', '-')}"
        raise Failure(f"{option}: no answer, and nothing was written; --yes takes defaults", BAD_INPUT) from None
