"""What runs cost: whole ones in turn, and contact tracking alone."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from statistics import median

import numpy as np

from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import YAW, places_in
from omnisim.march.initial_state import initial_state, roller_azimuths, roller_directions
from omnisim.results.trajectory import Trajectory
from omnisim.run.simulation import simulate
from omnisim.run.tracking_cost import track
from omnisim.scene.scene import Scene

REPEATS = 5
PATIENCE = 8.0  # s for all repeats of all scenes of a race
SHORTEST = 1e-6  # s: a machine that cannot begin takes no time at all
STATES, ROUNDS = 1000, 200
INSIDE = 0.99  # of the half angle of a roller: so far from its middle it is looked at


def interleaved(
    scenes: Sequence[Scene], repeats: int, progress: Callable[[float], object] = lambda _: None
) -> Iterator[list[tuple[float, float]]]:
    """Round by round the wall times of march and whole call (s) of each scene: A B C A B C ..., so that a machine that
    slows down slows all of them. progress: called with the fraction done before each run.
    """
    for turn in range(repeats):
        taken = []
        for place, scene in enumerate(scenes):
            progress((turn + place / len(scenes)) / repeats)
            begun = time.perf_counter()
            march = simulate(scene).attributes["wall_time"]
            taken.append((march, time.perf_counter() - begun))
        yield taken


def race(scenes: Sequence[Scene]) -> tuple[list[Trajectory], list[list[float]]]:
    """The trajectory of each scene, and its wall times (s, marching only): up to REPEATS, fewer of long runs.

    A step that is picked for an error is picked once.
    """
    trajectories = [simulate(scene) for scene in scenes]
    steps = [trajectory.attributes["step"] for trajectory in trajectories]
    scenes = [replace(scene, config=scene.config.at_step(step)) for scene, step in zip(scenes, steps, strict=True)]
    times = [[trajectory.attributes["wall_time"]] for trajectory in trajectories]
    once = sum(spent[0] for spent in times)
    for taken in interleaved(scenes, min(REPEATS, int(PATIENCE / max(once, SHORTEST))) - 1):
        for spent, (march, _) in zip(times, taken, strict=True):
            spent.append(march)
    return trajectories, times


def tracking_costs(scenes: Sequence[Scene]) -> list[float]:
    """Seconds for one evaluation of the contact tracking of each scene: medians of REPEATS, taken in turn."""
    costs = [[tracking_cost(scene) for scene in scenes] for _ in range(REPEATS)]
    return [median(cost) for cost in zip(*costs, strict=True)]


def tracking_cost(scene: Scene) -> float:
    """Seconds for one evaluation of the scene's tracking, all wheels; every evaluation has another state."""
    parameters = pack(scene.config)
    states = states_in_contact(scene, parameters)
    slopes = np.zeros_like(states)
    track(parameters, states, slopes, 1)  # compiles, or loads from the cache
    begun = time.perf_counter()
    track(parameters, states, slopes, ROUNDS)
    return (time.perf_counter() - begun) / (ROUNDS * STATES)


def states_in_contact(scene: Scene, parameters: Parameters) -> np.ndarray:
    """States of the scene's machine (STATES, n), of different yaw and spin angle, roller 0 in contact."""
    first, _ = initial_state(scene.config, parameters)
    states = np.tile(first, (STATES, 1))
    states[:, YAW] = np.linspace(0.0, 2.0 * np.pi, STATES)
    at = places_in(parameters)
    for w, wheel in enumerate(parameters.wheels):
        spin_angle = wheel.phase + wheel.alpha * np.linspace(-INSIDE, INSIDE, STATES)
        states[:, at.spin_angle + w] = spin_angle
        if parameters.machine.implicit_tracking:
            heading = states[:, YAW] + math.atan2(wheel.sin_heading, wheel.cos_heading)
            rho = -roller_directions(roller_azimuths(wheel, spin_angle), heading)
            first_rho = at.rho + 3 * w * parameters.sector.shape[2]
            states[:, first_rho : first_rho + 3 * wheel.rollers] = rho.reshape(STATES, -1)
    return states
