"""What a scene may say: defaults, derived values, and one line for every defect."""
# ruff: noqa: E501 (the table of defects reads best with one defect to a line)

import math
import tomllib
from pathlib import Path

import pytest
from scene_text import assert_one_line, message, replaced

from omnisim.scene.drives import voltage_limit
from omnisim.scene.problems import ConfigError
from omnisim.scene.scene import parse
from omnisim.scene.schema import Config, unused_keys
from omnisim.scene.validation import validate

pytestmark = pytest.mark.short

REFERENCE = Path(__file__).parents[1] / "reference"
GOOD = """\
schema = 1
title = "good"
[scene]
gravity = 9.81
upright = "servo"
[time]
end = 2.0
step = 0.001
output_interval = 0.05
[solver]
method = "rk4"
tracking = "explicit"
[friction]
law = "regularized"
coefficient = 0.4
slip_speed = 0.05
[wheel_types.omni]
radius = 0.05
roller_distance = 0.04
roller_count = 6
roller_angle_deg = 0.0
disk = { mass = 0.5, inertia_axle = 4e-4, inertia_diameter = 2.2e-4 }
roller = { mass = 0.03, inertia_axial = 6e-6, inertia_transverse = 9e-6 }
[[wheels]]
name = "wheel"
type = "omni"
spin_rate = 12.0
drive = { kind = "torque", times = [0, 1], torque = [0, 0.1] }
[wrench]
times = [0, 1]
force = [[1, 2, 3], [4, 5, 6]]
yaw_torque = [0, 1]
[initial]
velocity = [0.5, 0.3]
"""
MINIMAL = """\
schema = 1
time = { end = 1, step = 0.001 }
friction.law = "none"
[wheel_types.omni]
radius = 1
roller_distance = 0.5
roller_count = 4
roller_angle_deg = -89
disk = { mass = 1, inertia_axle = 1, inertia_diameter = 1 }
roller = { mass = 1, inertia_axial = 2, inertia_transverse = 1 }
[[wheels]]
name = "w"
type = "omni"
"""


def changed(*pairs: str) -> str:
    return replaced(GOOD, *pairs)


def config_of(*pairs: str) -> Config:
    return parse(changed(*pairs)).config


# Each defect as (old, new, line, key and value, what is allowed); every one gives exactly one line.
STEP, RADIUS, SPIN = "step = 0.001", "radius = 0.05", "spin_rate = 12.0"
DRIVE = 'drive = { kind = "torque", times = [0, 1], torque = [0, 0.1] }'
TABLE = "times = [0, 1]\nforce"
RATE = "drive = {kind = 'rate', proportional = 1"
SHEET = "drive = {kind = 'dc_motor', stall_torque = 0.49, stall_current = 20, no_load_speed = 950, no_load_current = 0.4, nominal_voltage = 24"
PI = "drive = {kind = 'dc_motor', proportional = 2, resistance = 2, torque_constant = 0.02"
MOTOR = "drive = {kind = 'dc_motor', voltage = 12, resistance = 2, torque_constant = 0.02"
DEFECTS = {
    "misspelt key": (SPIN, "spin_rat = 1", 27, "wheels.wheel.spin_rat = 1", "unknown key; did you mean 'spin_rate'?"),
    "misspelt required key": (STEP, "stp = 1", 8, "time.stp = 1", "did you mean 'step'? Allowed: end, step, output_in"),
    "misspelt table": ("[friction]", "[fricton]", 13, "fricton = {", "did you mean 'friction'?"),
    "unknown key": (STEP, STEP + "\nzzz = 1", 9, "time.zzz = 1", "unknown key. Allowed: end, step"),
    "unknown inline key": ("mass = 0.5", "mass=1, x=2", 22, "wheel_types.omni.disk.x = 2", "Allowed: mass, inertia"),
    "missing step": (STEP + "\n", "", 6, "time.step", "missing; must be a finite number > 0, or the scene has a solver.error"),
    "missing key": ("end = 2.0\n", "", 6, "time.end", "missing; must be a finite number > 0"),
    "missing root key": ("schema = 1\n", "", 1, "schema", "missing; must be 1"),
    "missing table": ("[time]\nend = 2.0\nstep = 0.001\noutput_interval = 0.05\n", "", 1, "time", "missing; must be a "),
    "missing inline key": ("mass = 0.5, ", "", 22, "wheel_types.omni.disk.mass", "missing; must be a finite"),
    "missing wheel name": ('name = "wheel"\n', "", 24, "wheels[0].name", "missing; must be a name (a letter,"),
    "schema of the future": ("schema = 1", "schema = 2", 1, "schema = 2", "must be 1"),
    "boolean for an integer": ("schema = 1", "schema = true", 1, "schema = true", "must be 1"),
    "number for a string": ('"good"', "3", 2, "title = 3", "must be a string"),
    "no error at all": ('"rk4"', '"rk4"\nerror = 0', 12, "solver.error = 0", "must be a finite number > 0"),
    "unlimited error": ('"rk4"', '"rk4"\nerror = inf', 12, "solver.error = inf", "must be a finite number > 0"),
    "error in words": ('"rk4"', '"rk4"\nerror = "1e-6"', 12, "solver.error = '1e-6'", "did you mean 1e-06?"),
    "negative gravity": ("9.81", "-9.81", 4, "scene.gravity = -9.81", "must be a finite number >= 0"),
    "vertical floor": ("[time]", "[floor]\nslope_deg = 90\n[time]", 7, "floor.slope_deg = 90", "must be a finite number from 0 to less than 90"),
    "floor that falls": ("[time]", "floor.slope_deg = -1\n[time]", 6, "scene.floor", "unknown key"),
    "negative slope": ("[time]", "[floor]\nslope_deg = -1\n[time]", 7, "floor.slope_deg = -1", "from 0 to less than 90"),
    "slope that is no number": ("[time]", "[floor]\nslope_deg = nan\n[time]", 7, "floor.slope_deg = nan", "from 0 to less than 90"),
    "uphill without bound": ("[time]", "[floor]\nuphill_deg = inf\n[time]", 7, "floor.uphill_deg = inf", "must be a finite number"),
    "slope in words": ("[time]", "[floor]\nslope_deg = '5'\n[time]", 7, "floor.slope_deg = '5'", "did you mean 5.0?"),
    "slope of the scene": ("[time]", "slope_deg = 5\n[time]", 6, "scene.slope_deg = 5", "unknown key. Allowed: gravity, upright"),
    "misspelt slope": ("[time]", "[floor]\nslop_deg = 5\n[time]", 7, "floor.slop_deg = 5", "did you mean 'slope_deg'? Allowed: slope_deg, uphill_deg"),
    "boolean for a number": (RADIUS, "radius = true", 18, "wheel_types.omni.radius = true", "a finite number > 0"),
    "string for a number": (STEP, 'step = "1e-3"', 8, "time.step = '1e-3'", "finite number > 0; did you mean 0.001?"),
    "date for a number": (STEP, "step = 1979-05-27", 8, "time.step = 1979-05-27", "must be a finite number > 0"),
    "not a number": (RADIUS, "radius = nan", 18, "wheel_types.omni.radius = nan", "must be a finite number > 0"),
    "infinite number": ("end = 2.0", "end = inf", 7, "time.end = inf", "must be a finite number > 0"),
    "integer beyond floats": (STEP, "step = 0x1" + "0" * 400, 8, "time.step = 0x1000", "must be a finite number > 0"),
    "zero step": (STEP, "step = 0", 8, "time.step = 0", "must be a finite number > 0"),
    "negative mass": ("mass = 0.03", "mass = -1", 23, "wheel_types.omni.roller.mass = -1", "finite number > 0"),
    "two rollers": ("count = 6", "count = 2", 20, "wheel_types.omni.roller_count = 2", "an integer from 3"),
    "rows that carry together": (
        "count = 6", "count = 6\nrows = [{ offset = -0.01 }, { offset = 0.01 }]", 21, "wheel_types.omni.rows = [{offset = -0.01}, {off",
        "must take turns, their phase_deg 360 / (roller_count * 2) = 30 apart; only upright = \"free\" in [scene] has wheels",
    ),
    "rows with gaps": (
        "count = 6", "count = 6\nrows = [{}, { phase_deg = 20 }]", 21, "wheel_types.omni.rows = [{}, {phase_deg = 20}]", "must take turns",
    ),
    "a gap between rollers": (
        "count = 6", "count = 6\ncovered_deg = 29", 21, "wheel_types.omni.covered_deg = 29", "must be absent or 180 / roller_count = 30; only upright",
    ),
    "rollers of rows that carry together": (
        "count = 6", "count = 6\ncovered_deg = 30\nrows = [{}, { phase_deg = 30 }]", 21, "wheel_types.omni.covered_deg = 30", "must be absent or 180 / (roller_count * 2) = 15",
    ),
    "no row": ("count = 6", "count = 6\nrows = []", 21, "wheel_types.omni.rows = []", "must be a list of one or more rows"),
    "misspelt row": ("count = 6", "count = 6\nrows = [{ ofset = 1 }]", 21, "wheel_types.omni.rows[0].ofset = 1", "unknown key; did you mean 'offset'?"),
    "float for an integer": ("count = 6", "count = 6.0", 20, "wheel_types.omni.roller_count = 6.0", "an integer from 3"),
    "psi of 90 deg": ("deg = 0.0", "deg = 90", 21, "roller_angle_deg = 90", "number between -90 and 90"),
    "string for a boolean": (SPIN, "mirrored = 'no'", 27, "wheels.wheel.mirrored = 'no'", "must be true or false"),
    "unknown word": ('"rk4"', '"rk5"', 11, "solver.method = 'rk5'", '"radau5" or "auto"; did you mean'),
    "unknown formulation": (
        '"rk4"', '"rk4"\nformulation = "full"', 12, "solver.formulation = 'full'", 'must be "reduced" or "multibody"',
    ),
    "implicit steps of bodies": (
        '"rk4"', '"radau5"\nformulation = "multibody"', 11, "solver.method = 'radau5'",
        "must be one of 'heun', 'rk4', 'dopri5', 'bs5' with formulation = 'multibody'",
    ),
    "loads in words": ("[time]", "[output]\nbearing_loads = 'yes'\n[time]", 7, "output.bearing_loads = 'yes'", "true or false"),
    "misspelt law": ('"regularized"', '"Regularised"', 14, "friction.law = 'Regularised'", "mean 'regularized'?"),
    "list for a word": ('"rk4"', '["rk4"]', 11, "solver.method = ['rk4']", 'must be "heun", "rk4", "dopri5", "bs5", "radau5" or "auto"'),
    "bad wheel name": ('"wheel"', '"1 wheel"', 25, "wheels[0].name = '1 wheel'", "must be a name (a letter"),
    "bad type name": ("omni]", '"om ni"]', 17, "wheel_types.'om ni' = {", "must be a name (a letter, then"),
    "unknown wheel type": ('"omni"', '"onmi"', 26, "wheels.wheel.type = 'onmi'", "did you mean 'omni'? Wheel types"),
    "number for a table": (DRIVE, "drive = 1", 28, "wheels.wheel.drive = 1", "must be a table with the keys kind,"),
    "table for an array": ("[[wheels]]", "[wheels]", 24, "wheels = {", "one or more tables [[wheels]]"),
    "three planar numbers": ("0.3]", "0.3, 0]", 34, "initial.velocity = [0.5, 0.3, 0]", "two finite numbers"),
    "one planar number": ("[0.5, 0.3]", "[0.5]", 34, "initial.velocity = [0.5]", "two finite numbers [x, y]"),
    "bad entry of a list": ("0.3]", "'a']", 34, "initial.velocity[1] = 'a'", "two finite numbers [x, y]"),
    "bad rates": (SPIN, "roller_rates = 'x'", 27, "wheels.wheel.roller_rates = 'x'", "or a list of roller_count"),
    "bad rate": (SPIN, "roller_rates = [1, true]", 27, "wheels.wheel.roller_rates[1] = true", "or a list of"),
    "five rates": (SPIN, "roller_rates = [1,2,3,4,5]", 27, "roller_rates = [1, 2, 3, 4, 5]", "_count = 6 finite"),
    "bare wheel elsewhere": (SPIN, "position = [1, 0]", 27, "wheels.wheel.position = [1, 0]", "absent or [0, 0]"),
    "bare wheel turned": (SPIN, "heading_deg = 5", 27, "wheels.wheel.heading_deg = 5", "must be absent or 0"),
    "rollers too far out": ("0.04", "0.0434", 19, "roller_distance = 0.0434", "cos(pi / roller_count) = 0.0433"),
    "impossible roller": ("axial = 6e-6", "axial = 6e-5", 23, "omni.roller.inertia_axial = 6e-05", "at most 2 * inert"),
    "law without its key": ("coefficient = 0.4\n", "", 13, "friction.coefficient", "missing; law = 'regularized' ne"),
    "viscous without viscosity": ('"regularized"', '"viscous"', 13, "friction.viscosity", "needs a finite number >= 0"),
    "unused key out of range": ("[wheel_t", "viscosity = -1\n[wheel_t", 17, "friction.viscosity = -1", "number >= 0"),
    "zero slip speed": ("speed = 0.05", "speed = 0", 16, "friction.slip_speed = 0", "must be a finite number > 0"),
    "output off the steps": (STEP, "step = 0.0003", 9, "time.output_interval = 0.05", "0.05 / 0.0003 = 166.666666"),
    "end off the output": ("end = 2.0", "end = 2.01", 9, "time.output_interval = 0.05", "end / output_interval"),
    "output after the end": ("= 0.05", "= 4.0", 9, "time.output_interval = 4.0", "= 0.5; must be an integer"),
    "too many steps": (STEP, "step = 1e-10", 8, "time.step = 1e-10", "2e+10 steps; must be at most 1e+10"),
    "vanishing step": (STEP, "step = 1e-320", 8, "time.step = 1e-320", "steps; must be at most 1e+10"),
    "drive without a kind": (DRIVE, "drive.torque = 1", 28, "wheels.wheel.drive.kind", 'must be "free", "torque", "follow", "rate" or "dc_motor"'),
    "drive without a torque": (DRIVE, "drive.kind = 'torque'", 28, "wheels.wheel.drive.torque", "missing; must be a fi"),
    "free drive with torque": ('"torque", times = [0, 1],', '"free",', 28, "wheels.wheel.drive.torque = [0, 0", "not a key"),
    "drive without times": ("times = [0, 1], ", "", 28, "wheels.wheel.drive.times", "missing; a list for torque needs a list of"),
    "one torque, two times": ("[0, 0.1]", "1", 28, "drive.torque = 1", "must be a list of 2 finite numbers"),
    "three torques, two times": ("[0, 0.1]", "[0, 0, 0]", 28, "drive.torque = [0, 0, 0]", "as times (2), not 3"),
    "falling drive times": ("[0, 1], t", "[0, -1], t", 28, "wheels.wheel.drive.times[1] = -1", "times never decrease"),
    "empty times": ("[0, 1], t", "[], t", 28, "wheels.wheel.drive.times = []", "a list of one or more finite numbers"),
    "wrench without times": (TABLE, "force", 29, "wrench.times", "missing; must be a list of one or more"),
    "falling wrench times": (TABLE, "times = [1, 0]\nforce", 30, "wrench.times[1] = 0", "must be at least 1.0"),
    "short force": (", [4, 5, 6]", "", 31, "wrench.force = [[1, 2, 3]]", "a list as long as times (2), not 1"),
    "planar force": ("[4, 5, 6]", "[4, 5]", 31, "wrench.force[1] = [4, 5]", "vectors [x, y, z] of finite numbers"),
    "flat force": ("[[1, 2, 3], [4, 5, 6]]", "[1, 2]", 31, "wrench.force[0] = 1", "a list of one or more vectors"),
    "long yaw torque": ("yaw_torque = [0, 1]", "yaw_torque = [0, 1, 2]", 32, "wrench.yaw_torque = [0, 1, 2]", "not 3"),
    "unknown frame": (TABLE, "frame = 'boddy'\n" + TABLE, 30, "wrench.frame = 'boddy'", "did you mean 'body'?"),
    "two wheels": ("[wrench]", "[[wheels]]\nname='b'\ntype='omni'\n[wrench]", 29, "wheels.b = {", "several wheels need a [chassis]"),
    "contacts of a bare wheel": ('"servo"', '"contacts"', 5, "scene.upright = 'contacts'", 'must be "servo" without a chassis'),
    "unknown upright": ('"servo"', '"contact"', 5, "scene.upright = 'contact'", '"servo", "contacts" or "free"; did you mean \'contacts\'?'),
    "rate drive without a rate": (DRIVE, f"{RATE}}}", 28, "wheels.wheel.drive.rate", "or the scene has a [command]"),
    "times without rates": (DRIVE, f"{RATE}, times = [0]}}", 28, "wheels.wheel.drive.rate", "missing; times need a list of"),
    "rate drive without a gain": (DRIVE, "drive = {kind = 'rate', rate = 1}", 28, "wheels.wheel.drive.proportional", "missing; must be a finite number > 0"),
    "unlimited torque": (DRIVE, f"{RATE}, rate = 1, torque_limit = inf}}", 28, "wheels.wheel.drive.torque_limit = inf", "must be a finite number > 0"),
    "no torque at all": (DRIVE, f"{RATE}, rate = 1, torque_limit = 0}}", 28, "wheels.wheel.drive.torque_limit = 0", "must be a finite number > 0"),
    "negative integral": (DRIVE, f"{RATE}, rate = 1, integral = -1}}", 28, "wheels.wheel.drive.integral = -1", "finite number >= 0"),
    "two rates, one time": (DRIVE, f"{RATE}, rate = [1, 2], times = [0]}}", 28, "wheels.wheel.drive.rate = [1, 2]", "as times (1), not 2"),
    "rates without times": (DRIVE, f"{RATE}, rate = [1, 2]}}", 28, "wheels.wheel.drive.times", "missing; a list for rate needs a list of as many"),
    "misspelt drive key": (DRIVE, f"{RATE}, rate = 1, torque_limt = 1}}", 28, "wheels.wheel.drive.torque_limt = 1", "did you mean 'torque_limit'?"),
    "misspelt kind": (DRIVE, "drive.kind = 'dcmotor'", 28, "wheels.wheel.drive.kind = 'dcmotor'", "did you mean 'dc_motor'?"),
    "motor without a resistance": (DRIVE, "drive = {kind = 'dc_motor', voltage = 12, torque_constant = 0.02}", 28, "wheels.wheel.drive.resistance", "missing; must be a finite number > 0"),
    "motor without a voltage": (DRIVE, "drive = {kind = 'dc_motor', resistance = 2, torque_constant = 0.02}", 28, "wheels.wheel.drive.voltage", "missing; must be a finite number or, with"),
    "motor with a torque": (DRIVE, f"{MOTOR}, torque = 1}}", 28, "wheels.wheel.drive.torque = 1", "not a key of a drive with kind = 'dc_motor'"),
    "voltage beside a controller": (DRIVE, f"{PI}, voltage = 12, rate = 1}}", 28, "wheels.wheel.drive.voltage = 12", "not beside a controller"),
    "controller without a gain": (DRIVE, "drive = {kind = 'dc_motor', rate = 1, resistance = 2, torque_constant = 0.02}", 28, "wheels.wheel.drive.proportional", "missing; must be a finite number > 0"),
    "voltage with a derivative": (DRIVE, f"{MOTOR}, sample_time = 0.01}}", 28, "wheels.wheel.drive.sample_time = 0.01", "is of a controller"),
    "controlled motor without a rate": (DRIVE, f"{PI}}}", 28, "wheels.wheel.drive.rate", "or the scene has a [command]"),
    "derivative at every instant": (DRIVE, f"{PI}, rate = 1, derivative = 1}}", 28, "wheels.wheel.drive.derivative = 1", "needs a sample_time"),
    "samples between steps": (DRIVE, f"{PI}, rate = 1, sample_time = 0.00015}}", 28, "wheels.wheel.drive.sample_time = 0.00015", "must be a multiple of"),
    "data sheet and constants": (DRIVE, f"{SHEET}, voltage = 24, resistance = 1.2}}", 28, "wheels.wheel.drive.resistance = 1.2", "follows from the data sheet"),
    "half a data sheet": (DRIVE, "drive = {kind = 'dc_motor', voltage = 24, stall_torque = 0.49, nominal_voltage = 24}", 28, "wheels.wheel.drive.stall_current", "missing; a data sheet is all of stall_torque, stall_current,"),
    "data sheet of a geared motor": (DRIVE, f"{SHEET.replace('0.49', '0.3')}, voltage = 24}}", 28, "wheels.wheel.drive.stall_torque = 0.3", "must be 0.4853 to 0.4952 N m"),
    "data sheet in turns a minute": (DRIVE, f"{SHEET.replace('950', '9072')}, voltage = 24}}", 28, "wheels.wheel.drive.stall_torque = 0.49", "contradicts the rest of the data sheet"),
    "no load beyond stall": (DRIVE, f"{SHEET.replace('0.4,', '40,')}, voltage = 24}}", 28, "wheels.wheel.drive.no_load_current = 40", "must be below stall_current = 20"),
    "motor without a gear": (DRIVE, f"{MOTOR}, gear_ratio = 0}}", 28, "wheels.wheel.drive.gear_ratio = 0", "must be a finite number > 0"),
    "command without a chassis": ("[initial]", "[command]\ntimes=[0]\ntwist=[[0, 0, 0]]\n[initial]", 33, "command = {", "needs a [chassis]"),
}  # fmt: skip


@pytest.mark.parametrize("defect", DEFECTS.values(), ids=DEFECTS.keys())
def test_one_defect_gives_one_line_with_file_line_key_value_and_what_is_allowed(defect):
    assert_one_line(GOOD, *defect)


def test_all_schema_problems_are_listed_in_the_order_of_the_file():
    text = message(changed("gravity = 9.81", "gravity = true", STEP, "step = 0", "[0.5, 0.3]", "3"))
    assert [line.split(":")[1] for line in text.splitlines()] == ["4", "8", "34"]


def test_an_empty_scene_names_everything_that_it_needs():
    keys = [line.split(": ")[1] for line in message("").splitlines()]
    assert keys == ["schema", "time", "friction", "wheel_types", "wheels"]


def test_absent_keys_have_the_defaults_of_the_contract():
    config = parse(MINIMAL).config
    wheel = config.wheels[0]
    assert (config.title, config.world.gravity, config.upright) == ("", 9.81, "servo")
    assert config.chassis is config.command is None
    assert (config.solver.method, config.solver.tracking) == ("rk4", "explicit")
    assert wheel.drive.kind == "free" and wheel.drive.table == ((0.0,), (0.0,))
    zeros = (wheel.heading_deg, wheel.phase_deg, wheel.spin_angle_deg, wheel.spin_rate, wheel.roller_rates)
    assert zeros == (0.0,) * 5 and wheel.mirrored is False
    assert config.initial.position == config.initial.velocity == (0.0, 0.0)
    assert config.wrench.table == ((0.0,), ((0.0, 0.0, 0.0),), (0.0,))
    assert config.type_of(wheel).roller_count == 4


def test_a_saturated_law_has_a_default_slip_speed_and_a_regularized_one_has_none():
    saturated = changed('"regularized"', '"saturated"', "slip_speed = 0.05\n", "")
    assert parse(saturated).config.friction.slip_speed == 1e-6
    assert "friction.slip_speed: missing" in message(changed("slip_speed = 0.05\n", ""))


def test_integers_pass_for_numbers_and_become_floats():
    config = config_of(RADIUS, "radius = 1", SPIN, "spin_rate = 3")
    assert isinstance(config.wheel_types["omni"].radius, float)
    assert isinstance(config.wheels[0].spin_rate, float)


def test_tables_are_equally_long_and_hold_zeros_where_the_scene_has_no_column():
    config = config_of("yaw_torque = [0, 1]\n", "")
    assert config.wrench.table == ((0.0, 1.0), ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)), (0.0, 0.0))
    assert config.wheels[0].drive.table == ((0.0, 1.0), (0.0, 0.1))
    assert config_of(DRIVE, "drive = {kind = 'torque', torque = 2}").wheels[0].drive.table == ((0.0,), (2.0,))


def test_two_equal_times_are_a_jump_and_allowed():
    assert config_of(TABLE, "times = [1, 1]\nforce").wrench.times == (1.0, 1.0)


def test_a_pointed_tip_typed_in_decimals_passes_and_one_beyond_it_does_not():
    limit = 0.05 * math.cos(math.pi / 6)
    config_of("0.04", repr(limit * (1 + 9e-13)))
    assert "must be at most" in message(changed("0.04", repr(limit * (1 + 2e-12))))


def test_a_roller_may_be_a_flat_disc():
    config_of("inertia_axial = 6e-6", "inertia_axial = 18e-6")


@pytest.mark.parametrize("word", ["position = [0, 0]", "position = [-0.0, 0.0]\nheading_deg = 0", "heading_deg = 0.0"])
def test_a_bare_wheel_may_say_that_it_stands_at_the_origin(word):
    config_of(SPIN, word)


@pytest.mark.parametrize(
    ("end", "step", "intervals"),
    [
        (2.0, 0.001, 100),
        (1.0, 0.001, 100),
        (6.5, 0.001, 100),
        (0.007, 0.001, 7),
        (10_007, 1, 10_007),  # a prime: rather all rows than one
        (1_000_003, 1, 1),  # a prime so large that all rows would be far too many
        (338, 1, 169),  # 26, 169: the second is nearer in the logarithm
        (1e4, 1e-6, 100),
    ],
)
def test_default_output_is_about_100_intervals_that_divide_the_steps(end, step, intervals):
    time = parse(MINIMAL.replace("end = 1, step = 0.001", f"end = {end}, step = {step}")).config.time
    assert time.outputs == intervals
    assert time.steps == round(end / step) == time.outputs * time.steps_per_output
    assert time.output_interval == time.steps_per_output * step


def test_without_an_output_interval_the_end_must_lie_on_the_steps():
    text = message(MINIMAL.replace("step = 0.001", "step = 0.0003"))
    assert (
        text == "s.toml:2: time.step = 0.0003: end / step = 1.0 / 0.0003 = 3333.33333333; must be an integer (to 1e-9)"
    )


def test_with_an_error_the_step_may_be_absent():
    time = config_of(STEP + "\n", "", '"rk4"', '"rk4"\nerror = 1e-6').time
    assert (time.step, time.output_interval, time.outputs) == (None, 0.05, 40)
    time = parse(MINIMAL.replace(", step = 0.001", "") + "[solver]\nerror = 1e-6\n").config.time
    assert (time.step, time.output_interval, time.outputs) == (None, 0.01, 100)
    text = message(changed("end = 2.0", "end = 2.01", STEP + "\n", "", '"rk4"', '"rk4"\nerror = 1e-6'))
    assert "time.output_interval = 0.05: end / output_interval = 2.01 / 0.05 = 40.2; must be an integer" in text


def test_given_output_is_kept_as_it_is():
    time = config_of().time
    assert (time.output_interval, time.steps_per_output, time.outputs, time.steps) == (0.05, 50, 40, 2000)


def test_ratios_of_times_are_integers_to_1e_9():
    config_of(STEP, f"step = {0.001 * (1 + 5e-10)!r}")
    assert "must be an integer" in message(changed(STEP, f"step = {0.001 * (1 + 2e-9)!r}"))


def test_ten_thousand_million_steps_are_allowed():
    assert config_of("end = 2.0", "end = 1e7", "= 0.05", "= 1e5").time.steps == 10**10


def test_keys_that_nothing_reads_are_named():
    config = config_of('"regularized"', '"viscous"', "[wheel_t", "viscosity = 1\n[wheel_t")
    assert unused_keys(config) == ("friction.coefficient", "friction.slip_speed")
    assert unused_keys(config_of()) == ()
    assert unused_keys(config_of('"regularized"', '"saturated"', "slip_speed = 0.05", "")) == ()
    type_text = MINIMAL[MINIMAL.index("radius") : MINIMAL.index("[[wheels]]")]
    config = parse(MINIMAL + "[wheel_types.spare]\n" + type_text).config
    assert unused_keys(config) == ("wheel_types.spare",)


def test_a_validated_scene_cannot_be_changed():
    config = config_of()
    with pytest.raises(ValueError):
        config.time.step = 1.0
    assert isinstance(config.wheels, tuple)


def test_drives_have_the_defaults_of_the_contract():
    rate = config_of(DRIVE, f"{RATE}, rate = 2}}").wheels[0].drive
    assert (rate.integral, rate.torque_limit, rate.follows_command) == (0.0, math.inf, False)
    motor = config_of(DRIVE, f"{MOTOR}}}").wheels[0].drive
    assert (motor.gear_ratio, motor.rotor_inertia, motor.viscosity) == (1.0, 0.0, 0.0)
    assert (motor.friction_torque, motor.friction_rate) == (0.0, 0.1)


def test_a_controlled_motor_has_the_nominal_voltage_of_its_data_sheet_unless_it_says_more():
    limits = [voltage_limit(config_of(DRIVE, f"{SHEET}, {text}}}").wheels[0].drive) for text in
              ("proportional = 1, rate = 1", "proportional = 1, rate = 1, voltage_limit = 30", "voltage = 48")]  # fmt: skip
    assert limits == [24.0, 30.0, math.inf]


def test_the_table_of_a_drive_holds_torques_rates_or_voltages():
    assert config_of(DRIVE, f"{RATE}, times = [0, 1], rate = [2, 3]}}").wheels[0].drive.table == (
        (0.0, 1.0),
        (2.0, 3.0),
    )
    assert config_of(DRIVE, f"{MOTOR}}}").wheels[0].drive.table == ((0.0,), (12.0,))


@pytest.mark.parametrize("path", sorted(REFERENCE.glob("testbench*.toml")), ids=lambda path: path.stem)
def test_reference_testbenches_are_good_scenes(path):
    validate(tomllib.loads(path.read_text()))


def test_problems_of_plain_data_carry_their_paths():
    with pytest.raises(ConfigError) as error:
        validate(tomllib.loads(changed(RADIUS, "radius = -1")))
    assert [problem.path for problem in error.value.problems] == [("wheel_types", "omni", "radius")]
