"""A roller of every profile but the exact one, about as long and thick as one another."""

from omnisim.scene.ground_schema import Profile

PROFILES = {
    "arc": {"kind": "arc", "radius": 0.01, "curvature_radius": 0.05, "half_length": 0.018},
    "cylinder": {"kind": "cylinder", "radius": 0.01, "half_length": 0.016, "edge_radius": 0.003},
    "sharp cylinder": {"kind": "cylinder", "radius": 0.01, "half_length": 0.016},
    "capsule": {"kind": "capsule", "radius": 0.01, "half_length": 0.017},
    "sphere": {"kind": "sphere", "radius": 0.012},
    "cone": {"kind": "cone", "radius": 0.01, "end_radius": 0.006, "half_length": 0.017},
    "stepped": {"kind": "stepped", "radii": [0.01, 0.0085, 0.006], "lengths": [0.006, 0.006, 0.004]},
    "points": {"kind": "points", "axial": [-0.018, -0.012, -0.005, 0.001, 0.008, 0.013, 0.016],
               "radius": [0.0055, 0.008, 0.0096, 0.01, 0.0093, 0.0079, 0.0064]},
}  # fmt: skip


def shape(name):
    """The profile, as a scene has it."""
    return Profile(**{key: tuple(value) if isinstance(value, list) else value for key, value in PROFILES[name].items()})
