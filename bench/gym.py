"""Environments: steps of 64 machines that follow a path, on all cores, beside MuJoCo's rollout of as many models.

Each step of an environment is 10 ms of one machine. omnisim's go through omnisim.gym, with observations and rewards:
the youBot on its circle, steered by the twist of the path and feedback of its error, and by random twists, under which
its wheels slip and stop all the time; and the mecanum platform of machine_scenes.py, which MuJoCo has too, as it slides
sideways by constant torques for as long as RAMP. Threads share steps that take long enough, as those of the packaged
youBot do. MuJoCo rolls out 64 models of the platform, over as many threads; its controls are known before, and it
returns states alone.
"""

import statistics
from collections.abc import Callable
from functools import cache

import numpy as np
from gymnasium import make_vec
from gymnasium.vector import VectorEnv

import omnisim
from bench.common import Claim, median_ratio, rates_in_turn, table
from bench.machine_scenes import RAMP
from bench.peers.mujoco_peer import mujoco
from bench.peers.mujoco_platform import HOW, LEVEL, Setup, model, rollout, scene
from omnisim.studies.workers import cores

NAME = "omnisim.gym:omnisim/Follow-v0"
MACHINES, CONTROL = 64, 100.0  # machines; Hz
GAIN = 3.0  # of the feedback, 1/s
MOTION = "sideways"
STEPS, FEW = round(RAMP * CONTROL), 10  # of each machine in a round; of those that slip
COARSE = 0.01  # step, s: the youBot ends 3e-6 m off after 4 s on a circle
FOLLOWING, AS_PACKAGED, WILD = "youBot, follows a circle", "youBot, follows, packaged step", "youBot, random twists"
ALONE, SLIDING = f"{AS_PACKAGED}, 1 thread", "platform, by torques"


def measure(rounds: int) -> dict:
    """Steps a second of every contestant, round by round in turn."""
    contestants: dict[str, Callable[[], int]] = {
        FOLLOWING: following,
        AS_PACKAGED: lambda: following(step=None),
        ALONE: lambda: following(1, None),
        WILD: wild,
        SLIDING: sliding,
    }
    if mujoco is not None:
        for contact, integrator, step in HOW:
            setup = Setup(MOTION, LEVEL, contact, integrator, step)
            contestants[f"platform, MuJoCo rollout, {contact}, {integrator}, {step:g} s"] = rolled(setup)
    return {"cores": cores(), "rates": rates_in_turn(contestants, rounds)}


@cache
def youbots(threads: int | None, step: float | None) -> VectorEnv:
    """On their circle; step: in place of that of the packaged scene, s."""
    scene = omnisim.load("youbot", {"time.step": step} if step else {})
    return make_vec(NAME, MACHINES, scene=scene, threads=threads, autoreset_mode="Disabled")


@cache
def platforms() -> VectorEnv:
    """Anywhere, by torques."""
    torques = [abs(wheel.drive.torque[0]) for wheel in scene(MOTION).config.wheels]
    still = [[0.0, 0.0, 0.0, 0.0], [RAMP, 0.0, 0.0, 0.0]]
    options = {"action": "torque", "limits": torques, "path": still, "reach": 10.0, "autoreset_mode": "Disabled"}
    return make_vec(NAME, MACHINES, scene=scene(MOTION), **options)


def following(threads: int | None = None, step: float | None = COARSE) -> int:
    many = youbots(threads, step)
    limits = many.actions.limits
    observed, _ = many.reset(seed=0)
    for _ in range(STEPS):
        observed, *_ = many.step((observed[:, 3:6] + GAIN * observed[:, :3]) / limits)
    return MACHINES * STEPS


def wild() -> int:
    many, random = youbots(None, COARSE), np.random.default_rng(0)
    many.reset(seed=0)
    for _ in range(FEW):
        many.step(random.uniform(-1.0, 1.0, many.action_space.shape))
    return MACHINES * FEW


def sliding() -> int:
    many = platforms()
    actions = np.tile(np.sign([wheel.drive.torque[0] for wheel in scene(MOTION).config.wheels]), (MACHINES, 1))
    many.reset(seed=0)
    for _ in range(STEPS):
        many.step(actions)
    return MACHINES * STEPS


def rolled(setup: Setup) -> Callable[[], int]:
    """The platform in MuJoCo."""
    go = rollout(setup, [model(setup) for _ in range(MACHINES)], RAMP)
    return lambda: MACHINES * STEPS if go() else 0


def report(result: dict) -> str:
    rows = [[name, f"{statistics.median(values):.0f}"] for name, values in result["rates"].items()]
    return table([f"{MACHINES} machines on {result['cores']} cores", "steps of 10 ms a second"], rows)


def claims(result: dict) -> list[Claim]:
    rates = result["rates"]
    threads = median_ratio(rates[AS_PACKAGED], rates[ALONE])
    text = f"steps of {MACHINES} youBots of the packaged step on {result['cores']} cores, by those on one"
    ratios = [shared / alone for shared, alone in zip(rates[AS_PACKAGED], rates[ALONE], strict=True)]
    reason = (
        "A step of all takes one thread 1.6 ms on an EPYC of the fourth generation: 0.07 of them are no march and stay "
        "with it, the other thread wakes 0.08 later, and one of them ends 0.03 before the last piece is done; of "
        f"{len(ratios)} rounds the ratio is {min(ratios):.2f} at least and {max(ratios):.2f} at most"
    )
    found = [Claim(text, threads, "at least", 0.9 * result["cores"], 0.5 * result["cores"], reason)]
    theirs = [name for name in rates if "MuJoCo" in name]
    if theirs:
        fastest = max(theirs, key=lambda name: statistics.median(rates[name]))
        times = median_ratio(rates[SLIDING], rates[fastest])
        text = "environment steps of the platform, by those of MuJoCo's fastest rollout"
        found.append(Claim(text, times, "at least", 5.0, 2.5))
    return found
