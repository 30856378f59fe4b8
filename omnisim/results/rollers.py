"""What a trajectory tells of the rollers of a wheel, beyond its datasets."""

import numpy as np

from omnisim.results.layout import Recorded


def joint_angles(trajectory: Recorded, wheel: str) -> np.ndarray:
    """Angles (T, N_r) of the rollers relative to their wheel, rad, 0 in the first row: the integral of their rates by
    the trapezoidal rule, good enough to see a roller turn."""
    time, rate = trajectory.time, trajectory[f"wheels/{wheel}/rollers/joint_rate"]
    angle = np.zeros_like(rate)
    angle[1:] = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time)[:, None], axis=0)
    return angle
