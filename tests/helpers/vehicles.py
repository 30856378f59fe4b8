"""A good vehicle of four mecanum wheels, as text to change: VEHICLE with free wheels, FOLLOWING with a command."""

VEHICLE = """\
schema = 1
time = { end = 1, step = 0.001 }
friction.law = "none"
wheels = [
    { name = "fl", type = "mecanum", position = [0.2, 0.1] },
    { name = "fr", type = "mecanum", position = [0.2, -0.1], mirrored = true },
    { name = "rl", type = "mecanum", position = [-0.2, 0.1], mirrored = true },
    { name = "rr", type = "mecanum", position = [-0.2, -0.1] },
]
[scene]
upright = "contacts"
[wheel_types.mecanum]
radius = 0.05
roller_distance = 0.04
roller_count = 6
roller_angle_deg = 45.0
disk = { mass = 0.4, inertia_axle = 4e-4, inertia_diameter = 2.2e-4 }
roller = { mass = 0.1, inertia_axial = 6e-6, inertia_transverse = 9e-6 }
[chassis]
mass = 6.0
center_of_mass = [0.02, 0.0, 0.1]
inertia = [0.1, 0.2, 0.25]
"""
FOLLOWING = (
    VEHICLE.replace(" },\n", ', drive = { kind = "rate", proportional = 0.5 } },\n')
    + """\
[command]
times = [0, 1]
twist = [[0, 0, 0], [0.5, 0.2, -1]]
"""
)
