"""Writes docs/pages/scene.md, every key of a scene file, from omnisim/scene/schema.py: python -m docs.scene_reference"""

import inspect
import math
from pathlib import Path
from typing import Any, get_args

from pydantic.fields import FieldInfo

from omnisim.scene.drive_schema import DATA_SHEET, DRIVE_KEYS, DriveKeys
from omnisim.scene.schema import FRICTION_DEFAULTS, FRICTION_KEYS, Config
from omnisim.scene.values import Table

PAGE = Path(__file__).parent / "pages/scene.md"
INTRODUCTION = """# Scene file

Written by `python -m docs.scene_reference` from the schema that checks every scene.

A scene is a TOML file. Units are SI; angles are radians, and degrees in keys that end in `_deg`. Integers pass for
numbers; booleans and strings never do. An unknown key, a missing one or a value out of bounds is answered with file,
line, key, value and what is allowed. `omnisim run SCENE --set KEY=VALUE` changes any key: `time.step=1e-4`,
`wheels.front_left.spin_rate=12`.

Tables over `times` are linear between their points and held outside. Times never decrease; two equal times are a jump.

## An example

A bare wheel, with most of what a scene can say; a machine stands under [Machines](machines.md).

```toml
schema = 1
title = "A wheel thrown sideways"

[time]
end = 2.0                     # s
step = 1e-3                   # fixed; events are located inside it
output_interval = 0.01

[solver]
method = "rk4"                # heun, rk4, dopri5, bs5; radau5 (implicit), auto (rk4, and radau5 where stiff)
tracking = "explicit"         # or implicit
formulation = "reduced"       # or multibody: every roller a body, every joint a multiplier
# error = 1e-6                # m, rad: a step is picked for it, and time.step is not used

[friction]
law = "regularized"           # regularized, saturated, coulomb, brush, viscous, none
coefficient = 0.4
slip_speed = 0.05             # m/s; coulomb needs none
# contact_torque = "contensou"  # friction of a patch against turning, with regularized slip; default "none"
# patch_radius = 0.002          # m

[wheel_types.omni]
radius = 0.05                 # m; the contact is always so far below the centre
roller_distance = 0.04        # wheel centre to roller centre
roller_count = 6
roller_angle_deg = 0.0        # 45 for a mecanum wheel
disk = { mass = 0.5, inertia_axle = 4e-4, inertia_diameter = 2.2e-4 }
roller = { mass = 0.03, inertia_axial = 6e-6, inertia_transverse = 9e-6 }
                              # bearing_viscosity (N m s), bearing_torque (N m), bearing_rate (rad/s): default frictionless
                              # rolling_resistance (m: moment by load), rolling_rate (rad/s): default none

[[wheels]]
name = "wheel"
type = "omni"
spin_rate = 12.0              # rad/s
drive = { kind = "torque", times = [0.0, 1.0], torque = [0.0, 0.05] }

[wrench]                      # external force and yaw torque at the wheel centre
frame = "body"
times = [0.0, 0.5, 0.5]       # two equal times: a jump
force = [[0.0, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.0]]

[initial]
velocity = [0.5, 0.3]
yaw_rate = 1.2

[output]
bearing_loads = true          # force and moment of every bearing
```
"""
RULES = """## Rules across keys

- `output_interval / step` and `end / output_interval` are integers, to 1e-9; a run has at most 1e10 steps.
- `formulation = "multibody"` takes an explicit method. `contact_torque = "contensou"` needs the regularized law.
- `roller_distance` is at most `radius cos(pi / roller_count)`, where the tips of the rollers are points; with `rows`,
  `radius cos(pi / (roller_count * rows))`.
- `rows` of an upright machine take turns: their `phase_deg` are `360 / (roller_count * rows)` apart, in any order, so that
  one roller carries at a time and the contact goes from row to row. Rollers of a wheel are counted in order of azimuth, from
  roller 0 of the first row on. A machine with `upright = "free"` may have any.
- `from` takes over the keys of a [packaged wheel](wheels.md) that the table leaves out, those of `disk`, `roller` and `profile`
  each on its own. What is loaded has these keys in its place, so that a trajectory's scene needs no wheel of that name.
- Masses and inertias may be left out where shapes give them: a roller has a `mass` or a `density`; a disk has
  `inertia_axle` or `hub_radius`, and `inertia_diameter` or `width`; a chassis has a `size`, or both `center_of_mass`
  and `inertia`. Given numbers win; `omnisim info` lists the estimates, and what each does to the motion. The
  `bore_radius` of a roller is less than its radius amid, that of a disk less than `hub_radius`; plates have both their keys,
  and a hub to stand on: `plate_radius` is more than `hub_radius`, `plate_thickness` at most half the `width`.
- Moments of inertia are those that a body can have: `inertia_axial` at most twice `inertia_transverse`; each of a
  chassis at most the sum of the other two.
- A scene without `[chassis]` has one wheel, and `[initial]` places it. With one, every wheel has a position; names are
  unique.
- `upright = "contacts"` needs three wheels or more, not on one line, with the common centre of mass between them.
- `[command]` needs a chassis, and wheels with drives that follow a rate and have no `rate`, which together determine the motion.
- A `dc_motor` has a `voltage`, or `proportional` and what else belongs to a controller; and either `resistance`,
  `torque_constant` and friction, or all five values of a data sheet, which must be those of one motor: `stall_torque` to
  5 %. `sample_time` is a multiple of `time.step`; with `solver.error`, of a thousandth of `output_interval`.
- A `profile` but `exact` is for machines free in space, and has the keys of its kind. `end_radius` is less than `radius`;
  `edge_radius` at most `radius` and `half_length`, which a capsule's `radius` is at most too; `curvature_radius` at least
  `half_length`. `radii` fall, 8 of them at most, with as many `lengths`. Points are 3 to 20, from `axial` below 0 to above
  0, each farther along and outside the line between its neighbours. Rollers of a row stand apart, and over the gaps
  between them they carry the wheel higher than its `hub_radius`.
- `bumps`, `grid` and `steps` need `upright = "free"`; no bump is narrower than a roller is thick. A file of heights is a
  table of numbers without holes, 2 x 2 to 1e6 of them; its name is relative to the scene file. What is loaded keeps the
  heights themselves, compressed, so that a trajectory's scene needs no other file.
- A list over `times` is as long as `times`; in `[wrench]` and `[command]` too.
"""
# Defaults that depend on other keys, or that are no value.
DERIVED = {
    "[scene] upright": '`"servo"` for a bare wheel, `"contacts"` for a machine',
    "[time] step": "required, unless `solver.error` picks one",
    "[time] output_interval": "about `end / 100`, on the grid of the steps",
    "[solver] error": "none: `time.step` is used",
    "[friction] patch_radius": 'required by `contact_torque = "contensou"`',
    "[wheel_types.NAME] from": "absent: no key is taken over",
    "[wheel_types.NAME] disk inertia_axle": "that of a cylinder, by `hub_radius`",
    "[wheel_types.NAME] disk inertia_diameter": "that of a cylinder, by `width`",
    "[wheel_types.NAME] disk hub_radius": "absent: not known",
    "[wheel_types.NAME] disk width": "absent: not known",
    "[wheel_types.NAME] disk plate_radius": "absent: no plates",
    "[wheel_types.NAME] disk plate_thickness": "absent: no plates",
    "[wheel_types.NAME] roller mass": "that of the profile's solid, by `density`",
    "[wheel_types.NAME] roller density": "absent: not known",
    "[wheel_types.NAME] roller inertia_axial": "that of the profile's solid",
    "[wheel_types.NAME] roller inertia_transverse": "the same",
    "[chassis] center_of_mass": "the middle of a box, by `size`",
    "[chassis] inertia": "that of a box, by `size`",
    "[chassis] size": "absent: not known",
    "[chassis] ground_clearance": "half the smallest wheel radius",
    "[[wheels]] position": "required in a machine, absent on a bare wheel",
    "[[wheels]] drive rate": "that of `[command]`",
    "[[wheels]] drive times": "absent: constant",
    "[[wheels]] drive voltage": "that of a controller",
    "[[wheels]] drive proportional": "required by `rate` and by a controlled `dc_motor`",
    "[[wheels]] drive sample_time": "absent: it acts at every instant",
    "[[wheels]] drive voltage_limit": "`nominal_voltage` of a controlled `dc_motor`, or none",
    "[[wheels]] drive resistance": "required by `dc_motor`, or a data sheet",
    "[[wheels]] drive torque_constant": "required by `dc_motor`, or a data sheet",
    **{f"[[wheels]] drive {key}": "absent; required of a data sheet" for key in DATA_SHEET},
    "[wheel_types.NAME] covered_deg": "`180 / roller_count`, by the number of rows if they take turns",
    "[wheel_types.NAME] profile radius": "required but by `exact` and `stepped`",
    "[wheel_types.NAME] profile curvature_radius": "required by `arc`",
    "[wheel_types.NAME] profile half_length": "required by `arc`, `cylinder`, `capsule` and `cone`",
    "[wheel_types.NAME] profile end_radius": "required by `cone`",
    "[wheel_types.NAME] profile radii": "required by `stepped`",
    "[wheel_types.NAME] profile lengths": "required by `stepped`",
    "[wheel_types.NAME] profile axial": "required by `points`",
    "[initial] height": "that of static equilibrium on the ground",
    "[initial] pitch_deg": "the same, or `0` beside a height or a roll",
    "[initial] roll_deg": "the same, or `0` beside a height or a pitch",
    "[wrench] times": "required in the table",
    "[wrench] force": "absent: zero",
    "[wrench] yaw_torque": "absent: zero",
}


def page() -> str:
    """The whole page as Markdown."""
    keys = "\n".join([*rows("[]", Config), ""])
    return "\n".join([INTRODUCTION, "## Keys outside of tables\n", keys, *sections(Config), RULES])


def sections(model: type[Table], above: str = "") -> list[str]:
    """One section for each table, those inside it after it."""
    found = []
    for name, field in model.model_fields.items():
        table = table_of(field)
        if table:
            heading = header(field.alias or name, field, above)
            found += [f"## `{heading}`\n", about(table), "", *rows(heading, table), "", *choices(heading)]
            found += sections(table, heading)
    return found


def table_of(field: FieldInfo) -> type[Table] | None:
    """The table that a key holds, one or several of them; None if it holds a value."""
    waiting = [field.annotation]
    while waiting:
        kind = waiting.pop()
        if inspect.isclass(kind) and issubclass(kind, Table):
            return kind
        waiting += get_args(kind)
    return None


def header(name: str, field: FieldInfo, above: str) -> str:
    """How the table is opened in the file, or the key that holds it as an inline table."""
    if above:
        return f"{above} {name}"
    kind = str(field.annotation)
    return f"[[{name}]]" if kind.startswith("tuple") else f"[{name}.NAME]" if kind.startswith("dict") else f"[{name}]"


def about(table: type[Table]) -> str:
    """The docstring without the name of the table; columns as they are."""
    paragraphs = inspect.cleandoc(table.__doc__).split("\n\n")
    start, _, rest = paragraphs[0].partition(": ")
    if start.startswith("[") or start == "drive of a wheel":
        paragraphs[0] = rest[:1].upper() + rest[1:]
    return "\n\n".join(map(prose, paragraphs))


def prose(paragraph: str) -> str:
    if "   " in paragraph:
        return f"```text\n{paragraph}\n```"
    return paragraph.replace(". None", ". Absent").replace("None", "absent")


def rows(heading: str, model: type[Table]) -> list[str]:
    """The keys that hold values, as a table."""
    values = [(field.alias or name, field) for name, field in model.model_fields.items() if not table_of(field)]
    lines = [f"| `{key}` | {field.description or 'a finite number > 0'} | {default(heading, key, field)} |"
             for key, field in values]  # fmt: skip
    return ["| key | value | default |", "| --- | --- | --- |", *lines]


def default(heading: str, key: str, field: FieldInfo) -> str:
    if f"{heading} {key}" in DERIVED:
        return DERIVED[f"{heading} {key}"]
    if field.is_required():
        return "required"
    return needed(heading, key) or shown(field.default)


def needed(heading: str, key: str) -> str:
    """By which laws or drives a key is needed; empty if it is not."""
    if heading == "[friction]":
        by = [law for law, keys in FRICTION_KEYS.items() if key in keys and key not in FRICTION_DEFAULTS.get(law, {})]
        given = [f"{shown(keys[key])} for `{law}`" for law, keys in FRICTION_DEFAULTS.items() if key in keys]
    elif heading == "[[wheels]] drive":
        by, given = [kind for kind, keys in DRIVE_KEYS.items() if key in keys.needed], []
    else:
        return ""
    return ", ".join([f"required by {', '.join(f'`{name}`' for name in by)}"] * bool(by) + given)


def shown(value: Any) -> str:
    if value == math.inf:
        return "none"
    if isinstance(value, tuple):
        return f"`[{', '.join(f'{number:g}' for number in value)}]`"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"`{value:g}`"


def choices(heading: str) -> list[str]:
    """Which keys a law or a kind of drive reads."""
    if heading == "[friction]":
        lines = [f"| `{law}` | {listed(keys)} |" for law, keys in FRICTION_KEYS.items()]
        return ["| law | reads |", "| --- | --- |", *lines, "", "Keys of other laws are allowed, and not used.", ""]
    if heading == "[[wheels]] drive":
        titles = ["| kind | needs | may have | a number, or a list over `times` |", "| --- | --- | --- | --- |"]
        return [*titles, *(drive_line(kind, keys) for kind, keys in DRIVE_KEYS.items()), ""]
    return []


def drive_line(kind: str, keys: DriveKeys) -> str:
    return f"| `{kind}` | {listed(keys.needed)} | {listed(keys.optional)} | {listed(keys.given)} |"


def listed(keys: Any) -> str:
    return ", ".join(f"`{key}`" for key in keys) or "-"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
