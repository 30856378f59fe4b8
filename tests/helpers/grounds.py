"""A vehicle free in space on ground that is no plane, as text to change, and the heights that it names."""

from scene_text import replaced
from vehicles import VEHICLE

GROUND = replaced(
    VEHICLE, '"contacts"\n', """"free"
[floor]
bumps = [[0.3, 0.0, 0.012, 0.06], [1.0, 0.2, -0.01, 0.2]]
grid = { file = "hills.csv", origin = [-1.0, -1.0], spacing = [0.5, 0.4] }
[[floor.steps]]
point = [2.0, 0.0]
direction_deg = 0.0
height = 0.005
edge_radius = 0.002
""", "radius = 0.05\n", "radius = 0.05\ncontact = { stiffness = 1e6, damping = 100.0 }\n",
)  # fmt: skip
HILLS = "0, 0.01, 0.02, 0\n0, -0.005, 0.03, 0\n0.01, 0.02, 0.01, 0\n"
