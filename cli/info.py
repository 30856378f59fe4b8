"""`omnisim info`: what a scene models and why, or what a trajectory file holds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from omnisim.base.formatting import aligned, columns

from .compiling import compilation_noted
from .info_rest import Rest, jumps, rest_of, shape_facts
from .plot import study_in
from .screen import BAD_INPUT, Failure, warn

if TYPE_CHECKING:
    import numpy as np

    from omnisim.dynamics.parameters import Parameters
    from omnisim.scene.drive_schema import Drive
    from omnisim.scene.scene import Scene
    from omnisim.scene.schema import Config
    from omnisim.scene.wheel_schema import WheelType

UPRIGHT_DEG = 89.99  # a slope beyond is a wall


@click.command()
@click.argument("source", metavar="SCENE|FILE")
def info(source: str) -> None:
    """Say what SCENE models, what it leaves out and why; or what FILE holds, a trajectory or a study.

    \b
    omnisim info scene.toml
    omnisim info scene.h5
    """
    from omnisim.base.files import is_hdf5

    if study := study_in((source,)):
        from omnisim.studies.report import about

        click.echo(about(study))
    elif is_hdf5(source):
        click.echo(about_trajectory(source))
    else:
        from omnisim.scene.scene import load

        scene = load(source)
        warn(scene.warnings)
        click.echo(about_scene(scene))


def about_trajectory(path: str) -> str:
    from omnisim.base.trajectory_file import TrajectoryError
    from omnisim.results.report import summary
    from omnisim.results.trajectory import open_trajectory

    try:
        return summary(open_trajectory(path))
    except TrajectoryError as error:
        raise Failure(str(error), BAD_INPUT) from None


def about_scene(scene: Scene) -> str:
    """The size of the run, the model with its reasons, the machine, and each type of wheel."""
    from omnisim.dynamics.description import describe
    from omnisim.dynamics.packing import pack

    config = scene.config
    with compilation_noted([scene]):
        parameters = pack(config)
        rest = rest_of(scene, parameters)
        sections = [aligned(run_facts(scene, parameters)), describe(config, parameters).text]
        if found := estimate_table(config):
            sections.append(f"estimated from shapes, since the scene leaves them out\n{found}")
            sections.append(
                "what 10 % more of each changes, %: inertia that drives feel while no wheel slips; loads at 1 m/s^2\n"
                + influence_table(config)
            )
        if config.chassis:
            sections += [
                section("machine", machine_facts(parameters)),
                *([section("at rest on the ground", rest.facts)] if rest.facts else []),
                f"wheels\n{wheel_table(config, rest)}",
                f"spin rates of ideal wheels, which do not slip, rad/s\n{ideal_table(config)}",
                f"steepest slopes, deg: statics of wheels that stand on the middle of a roller, estimated\n"
                f"{slope_table(config, parameters)}",
            ]
        for drive, names in motors(config).items():
            sections.append(section(f"motor of {', '.join(names)}, at the wheel", motor_facts(drive)))
        for wheel, record in first_of_each_type(config, parameters):
            name = "wheel type" if config.chassis else f"wheel '{wheel.name}' of type"
            mirrored = ", mirrored" if wheel.mirrored else ""
            facts = wheel_facts(config.type_of(wheel), record)
            sections.append(section(f"{name} '{wheel.type}'{mirrored}", facts))
    return "\n\n".join(sections)


def section(heading: str, facts: dict[str, str]) -> str:
    return f"{heading}\n{aligned(facts, indent='  ')}"


def run_facts(scene: Scene, parameters: Parameters) -> dict[str, str]:
    from omnisim.march.stiffness import explanation

    time, solver = scene.config.time, scene.config.solver
    if solver.error is None:
        method = explanation(scene.config, parameters)
        steps = f"in {time.steps} steps of {time.step:g} s"
    else:
        method = solver.method
        steps = f"in steps that are picked for errors below {solver.error:g} m or rad"
    return {
        "scene": scene.config.title or "(no title)",
        "source": scene.source,
        "method": method,
        "tracking": solver.tracking,
        "run": f"{time.end:g} s {steps}",
        "output": f"{time.outputs + 1} rows, one every {time.output_interval:g} s",
    }


def estimate_table(config: Config) -> str:
    """One line for each number that the scene leaves out; empty if there is none."""
    from omnisim.scene.estimates import estimates
    from omnisim.scene.toml_text import show_path

    return columns([(show_path(found.path), found.value, found.of) for found in estimates(config)], indent="  ")


def influence_table(config: Config) -> str:
    """How much the motion depends on each of them, %."""
    from omnisim.dynamics.felt_inertia import influence
    from omnisim.scene.estimates import estimates
    from omnisim.scene.toml_text import show_path

    heads = ("ahead", "to the left", "turning", "load of a wheel")
    rows: list[tuple[str, ...]] = [("", *heads)]
    for found in estimates(config):
        changes = [f"{round(100.0 * change, 6) + 0.0:.2g}" for change in influence(config, found.path)]
        rows.append(
            (show_path(found.path), *(f"{change:>{len(head)}}" for change, head in zip(changes, heads, strict=True)))
        )
    return columns(rows, indent="  ")


def machine_facts(parameters: Parameters) -> dict[str, str]:
    """What all bodies make up together."""
    machine = parameters.machine
    x, y = machine.centre + 0.0
    weight = machine.mass * math.hypot(machine.gravity, *machine.downhill)
    return {
        "mass": f"{machine.mass:.6g} kg, chassis and wheels; weight {weight:.6g} N",
        "centre of mass": f"[{x:.6g}, {y:.6g}, {machine.height:.6g}] m in chassis axes, z above the floor",
        "yaw inertia": f"{machine.yaw_inertia:.6g} kg m^2 about it",
    }


def wheel_table(config: Config, rest: Rest) -> str:
    """One line for each wheel: where it is, what drives it, what it carries, and how far its spring is pressed in."""
    rows: list[tuple[str, ...]] = [("name", "type", "position", "heading", "mirrored", "drive", "load at standstill")]
    for w, wheel in enumerate(config.wheels):
        x, y = wheel.position
        place = f"[{x:g}, {y:g}] m"
        turned = f"{wheel.heading_deg:g} deg"
        mirrored = "yes" if wheel.mirrored else "no"
        load = f"{rest.loads[w]:.4g} N" if len(rest.loads) else "none"
        rows.append((wheel.name, wheel.type, place, turned, mirrored, wheel.drive.kind, load))
    if rest.travels:
        more = ("travel", *("no spring" if travel is None else f"{1e3 * travel:.3g} mm" for travel in rest.travels))
        rows = [(*row, extra) for row, extra in zip(rows, more, strict=True)]
    return columns(rows, indent="  ")


def ideal_table(config: Config) -> str:
    """Spin rates of the ideal wheels in the unit motions of the chassis origin."""
    from omnisim.scene.ideal_kinematics import wheel_rows

    motions = ("1 m/s forward", "1 m/s left", "1 rad/s of yaw")
    rows: list[tuple[str, ...]] = [("name", *motions)]
    for wheel, rates in zip(config.wheels, wheel_rows(config), strict=True):
        shown = zip(rates, motions, strict=True)
        rows.append((wheel.name, *(f"{round(rate, 9) + 0.0:>{len(motion)}.4g}" for rate, motion in shown)))
    return columns(rows, indent="  ")


def slope_table(config: Config, parameters: Parameters) -> str:
    """On which slopes the machine slides, rolls away without power, drives up no more, or tips."""
    from omnisim.dynamics.slopes import least, steepest

    found = {
        "ahead": steepest(config, parameters, 0.0),
        "to the left": steepest(config, parameters, 90.0),
        "any way, the least": least(config, parameters),
    }
    if config.floor.slope_deg:
        uphill_deg = config.floor.uphill_deg - config.initial.yaw_deg
        found[f"on its {config.floor.slope_deg:g} deg"] = steepest(config, parameters, uphill_deg)
    rows = [(name, *map(shown_slope, slopes)) for name, slopes in found.items()]
    return columns([("uphill", "holds, wheels locked", "rests, no power", "drives up", "tips"), *rows], indent="  ")


def shown_slope(slope: float) -> str:
    degrees = math.degrees(slope)
    return "never" if degrees > UPRIGHT_DEG else f"{round(degrees, 6) + 0.0:.3g}"


def motors(config: Config) -> dict[Drive, list[str]]:
    """The wheels of each motor, whatever it follows; a drive that stands for it, with a voltage of its own or none."""
    found: dict[Drive, list[str]] = {}
    for wheel in config.wheels:
        if wheel.drive.kind == "dc_motor":
            alike = wheel.drive.model_copy(update={"times": (), "voltage": 0.0, "rate": None})
            found.setdefault(alike, []).append(wheel.name)
    return found


def motor_facts(drive: Drive) -> dict[str, str]:
    """What follows from the constants of a motor or from its data sheet: at the wheel, behind the gear."""
    from omnisim.scene.drives import data_sheet, drive_law, motor_of, sheet_constants

    law = drive_law(drive)
    motor = motor_of(drive)
    gear = drive.gear_ratio
    facts = {
        "resistance": f"{motor.resistance:.6g} ohm",
        "torque constant": f"{motor.constant:.6g} N m/A or V s/rad; {motor.constant / gear:.6g} before its gear",
        "friction": f"{motor.friction_torque:.4g} N m, and {motor.viscosity:.4g} N m s by the spin rate",
    }
    if drive.nominal_voltage:
        sheet = sheet_constants(drive)
        voltage = drive.nominal_voltage
        speed = data_sheet(drive).no_load_speed / gear
        stall = gear * sheet.stall_torque
        facts |= {"without load": f"{speed:.4g} rad/s at {voltage:g} V", "stalled": f"{stall:.4g} N m at {voltage:g} V"}
    if drive.inductance:
        facts["current"] = f"settles in {motor.inductance / motor.resistance:.3g} s (L / R)"
    if math.isfinite(drive.current_limit):
        facts["current limit"] = f"{drive.current_limit:g} A: at most {motor.constant * drive.current_limit:.4g} N m"
    if law.rotor_inertia:
        facts["rotor"] = f"{law.rotor_inertia:.4g} kg m^2 about the axle"
    return facts


def first_of_each_type(config: Config, parameters: Parameters) -> list[tuple]:
    """A wheel and its record for each type in use; one that is not mirrored, if there is one."""
    found: dict[str, tuple] = {}
    for wheel, record in zip(config.wheels, parameters.wheels, strict=True):
        if wheel.type not in found or (found[wheel.type][0].mirrored and not wheel.mirrored):
            found[wheel.type] = (wheel, record)
    return list(found.values())


def wheel_facts(kind: WheelType, wheel: np.record) -> dict[str, str]:
    """Sizes that follow from the scene's."""
    from omnisim.contact.roller_profile import length, profile_radius, tip_radius

    psi = math.degrees(math.atan2(wheel.sin_psi, wheel.cos_psi))
    rows = f" in {len(kind.rows)} rows" if len(kind.rows) > 1 else ""
    facts = {
        "wheel radius": f"{wheel.radius:g} m",
        "rollers": f"{wheel.rollers}{rows}, axes at {wheel.roller_distance:g} m, angle {psi:g} deg",
    }
    if kind.contact is not None:
        facts |= shape_facts(kind)
    else:
        margin = wheel.radius * wheel.cos_alpha - wheel.roller_distance
        facts |= {
            "roller length": f"{length(wheel):.6g} m",
            "roller radius": f"{profile_radius(wheel, 0.0):.6g} m amid, {tip_radius(wheel):.6g} m at the tips",
            "margin": f"{max(margin, 0.0):.6g} m until the tips are points (R cos alpha - R1)",
            "exchange": f"every {math.degrees(2.0 * wheel.alpha):g} deg; the contact jumps {jumps(kind, wheel)}",
        }
    return facts | {"axle inertia": f"{wheel.axle_inertia:.6g} kg m^2 (J_k: disk and rollers about the axle)"}
