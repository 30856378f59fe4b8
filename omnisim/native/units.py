"""Units of a scene's numbers by their keys, and what a unit is by those of SI."""

import math
from collections import Counter

from omnisim.scene.schema import Config

KEYS = {  # of numbers in a scene, by unit; those that end in _deg are in degrees
    "1": ("coefficient", "creep_stiffness", "gear_ratio"),
    "s": ("sample_time",),
    "m": (
        "radius", "roller_distance", "hub_radius", "width", "bore_radius", "plate_radius", "plate_thickness", "offset",
        "curvature_radius", "half_length", "edge_radius", "end_radius", "patch_radius", "rolling_resistance", "height",
        "ground_clearance",
    ),
    "kg": ("mass",),
    "kg/m^3": ("density",),
    "kg m^2": (
        "inertia", "inertia_axle", "inertia_diameter", "inertia_axial", "inertia_transverse", "rotor_inertia",
    ),
    "m/s": ("slip_speed", "vertical_velocity"),
    "m/s^2": ("gravity",),
    "rad/s": (
        "spin_rate", "roller_rates", "rate", "yaw_rate", "pitch_rate", "roll_rate", "bearing_rate", "rolling_rate",
        "friction_rate", "no_load_speed",
    ),
    "N": ("preload",),
    "N/m": ("stiffness",),
    "N s/m": ("friction.viscosity", "damping"),
    "N m": ("torque", "torque_limit", "friction_torque", "stall_torque", "bearing_torque"),
    "N m s": ("drive.viscosity", "bearing_viscosity"),
    "N m/A": ("torque_constant",),
    "V": ("voltage", "voltage_limit", "nominal_voltage"),
    "A": ("current_limit", "stall_current", "no_load_current"),
    "ohm": ("resistance",),
    "H": ("inductance",),
}  # fmt: skip
UNITS = {key: unit for unit, keys in KEYS.items() for key in keys}
GAINS = {  # of controllers, by what they give
    "rate": {"proportional": "N m s/rad", "integral": "N m/rad"},
    "dc_motor": {"proportional": "V s/rad", "integral": "V/rad", "derivative": "V s^2/rad"},
}
DERIVED = {  # exponents of base units of SI
    "N": {"kg": 1, "m": 1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
}


def unit_of(config: Config, name: str) -> str:
    """Of a number of the scene by its dotted key, "1" of a ratio."""
    *above, table, key = name.split(".")
    if key.endswith("_deg"):
        return "deg"
    if table == "drive":
        kind = next(wheel.drive.kind for wheel in config.wheels if wheel.name == above[-1])
        if key in GAINS.get(kind, {}):
            return GAINS[kind][key]
    return UNITS.get(f"{table}.{key}") or UNITS[key]


def base_units(unit: str) -> dict[str, str]:
    """Exponents of the base units of SI, as attributes that FMI has for them: "N m/A" -> kg, m, s, A."""
    if unit == "deg":
        return {"rad": "1", "factor": repr(math.pi / 180.0)}
    above, _, below = unit.partition("/")
    found: Counter[str] = Counter()
    for part, sign in ((above, 1), (below, -1)):
        for word in part.split():
            symbol, _, power = word.partition("^")
            for base, exponent in DERIVED.get(symbol, {symbol: 1}).items():
                found[base] += sign * int(power or 1) * exponent
    return {base: str(exponent) for base, exponent in found.items() if exponent}
