"""Two controllers that drive a youBot along one path, for docs/pages/gym.md: python -m docs.follow (extras docs, gym)

One is classical, the other learns on many machines at once. Prints times and errors, draws pictures/follow.png.
"""

import time
from pathlib import Path

import gymnasium
import matplotlib.pyplot as plt
import numpy as np

import omnisim
import omnisim.gym

PICTURE = Path(__file__).parent / "pages/pictures/follow.png"
TIMES = 20  # as large are errors drawn
INK, WARM, COOL = "#1f2933", "#d1495b", "#00798c"
PATH = omnisim.gym.path("circle", size=0.5)
YOUBOT = omnisim.load("youbot", {"time.step": 0.01})  # coarse: see the page
LIMITS = np.array([1.0, 1.0, 3.0])  # of an action of 1: m/s, m/s, rad/s
VARY = {
    "friction.coefficient": {"uniform": [0.4, 0.8]},
    "chassis.mass": {"uniform": [15.0, 25.0]},
    "wheels.*.phase_deg": {"uniform": [0.0, 60.0], "each": True},
}
MACHINES, GENERATIONS = 32, 100
SPREAD, RATE, BEST = 0.03, 0.05, 8  # of the weights, in units of SCALE; of a step; directions that count in it
GAIN = 3.0  # of the classical controller, 1/s
SEEN = [0, 1, 2, 3, 4, 5, 13, 14, 15]  # of the observation: error, twist of the path, error 0.1 s ahead
SCALE = np.array([0.1, 0.1, 0.1, 1.0, 1.0, 1.0, 0.1, 0.1, 0.1])


def environment(count, vary=None):
    """So many youBots; nobody but us begins an episode."""
    return gymnasium.make_vec(
        "omnisim/Follow-v0", count, scene=YOUBOT, path=PATH, vary=vary, ahead=[0.1], autoreset_mode="Disabled"
    )


def classical(gain):
    """The twist of the path, and back what the machine is off it."""
    return lambda observed: (observed[:, 3:6] + gain * observed[:, :3]) / LIMITS


def linear(weights):
    """A policy with weights (3, 9), or (N, 3, 9) of its own for each machine."""
    return lambda observed: (weights * (observed[:, SEEN] / SCALE)[:, None]).sum(axis=-1)


def episode(many, policy, seed):
    """Mean rewards (N,) of an episode of each machine, by its whole path, and errors (steps, N, 3)."""
    observed, _ = many.reset(seed=seed)
    rewards, errors, over = 0.0, [], np.zeros(many.num_envs, bool)
    while not over.all():
        observed, reward, terminated, truncated, _ = many.step(policy(observed))
        rewards, over = rewards + reward, terminated | truncated
        errors.append(observed[:, :3])
    return rewards / many.path.steps, np.array(errors)


def learn():
    """Weights (3, 9) found by random search, and the mean reward of every generation.

    Machines try opposite changes in pairs. The weights move along the changes of the best pairs, by what their rewards
    differ (Mania, Guy, Recht: Simple random search of static linear policies, 2018).
    """
    many, random = environment(MACHINES, VARY), np.random.default_rng(0)
    weights, progress = np.zeros((3, len(SEEN))), []
    for generation in range(GENERATIONS):
        changes = random.standard_normal((MACHINES // 2, *weights.shape))
        rewards, _ = episode(
            many, linear(weights + SPREAD * np.concatenate([changes, -changes])), generation * MACHINES
        )
        plus, minus = rewards.reshape(2, -1)
        best = np.argsort(np.maximum(plus, minus))[-BEST:]
        slopes = (plus - minus)[best] / np.concatenate([plus[best], minus[best]]).std()
        rate = RATE * (1.0 - generation / GENERATIONS)
        weights = weights + rate / BEST * np.tensordot(slopes, changes[best], axes=1)
        progress.append(rewards.mean())
        if generation % 10 == 9:
            print(f"generation {generation + 1}: mean reward {progress[-1]:.4f}", flush=True)
    return weights, progress


def rms(errors):
    """Of distance, mm, and yaw, mrad, over time and machines."""
    return 1e3 * np.sqrt((errors[..., :2] ** 2).sum(axis=-1).mean()), 1e3 * np.sqrt((errors[..., 2] ** 2).mean())


def exaggerated(pose, errors):
    """Poses (steps, 3) whose distance from the path is TIMES as large: x and y."""
    x, y, _ = errors.T
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    return pose[:, :2] - (TIMES - 1.0) * np.column_stack([cos * x - sin * y, sin * x + cos * y])


def draw(driven, progress):
    figure, (path, error, learning) = plt.subplots(1, 3, figsize=(12, 4), layout="constrained")
    path.plot(PATH[:, 1], PATH[:, 2], color=INK, lw=4, alpha=0.15, label="path")
    for (name, (pose, errors)), colour in zip(driven.items(), (COOL, WARM), strict=True):
        distance, yaw = rms(errors)
        path.plot(*exaggerated(pose, errors).T, color=colour, lw=1.2, label=name)
        times = 0.01 * np.arange(1, len(errors) + 1)
        error.plot(
            times, 1e3 * np.hypot(*errors.T[:2]), color=colour, label=f"{name}: {distance:.1f} mm, {yaw:.0f} mrad"
        )
    path.set(aspect="equal", xlabel="x / m", ylabel="y / m", title=f"one youBot, two controllers, errors times {TIMES}")
    error.set(xlabel="t / s", ylabel="off the path / mm", title="error, with its RMS")
    learning.plot(np.arange(1, len(progress) + 1), progress, color=WARM)
    learning.set(xlabel="generation", ylabel="mean reward of a step", title=f"learning on {MACHINES} machines at once")
    for axes in (path, error):
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(PICTURE, dpi=110)


def main():
    begun, worked = time.perf_counter(), time.process_time()
    weights, progress = learn()
    print(f"learnt in {time.perf_counter() - begun:.0f} s, {time.process_time() - worked:.0f} s of processors")
    driven = {}
    alone, others = environment(1), environment(MACHINES, VARY)
    for name, policy in {"classical": classical(GAIN), "learnt": linear(weights)}.items():
        poses = []

        def noted(observed, policy=policy, poses=poses):
            poses.append(alone.machines.pose[0])
            return policy(observed)

        rewards, errors = episode(alone, noted, 0)
        driven[name] = np.array([*poses[1:], alone.machines.pose[0]]), errors[:, 0]
        told, told_of_others = rms(errors), rms(episode(others, policy, 10**6)[1])
        print(f"{name}: reward {rewards[0]:.5f}, RMS {told[0]:.2f} mm, {told[1]:.2f} mrad; "
              f"{MACHINES} machines never seen: {told_of_others[0]:.2f} mm, {told_of_others[1]:.2f} mrad")  # fmt: skip
    for gain in (0.0, 10.0):
        told = rms(episode(alone, classical(gain), 0)[1])
        print(f"classical, gain {gain:g}: RMS {told[0]:.2f} mm, {told[1]:.2f} mrad")
    draw(driven, progress)


if __name__ == "__main__":
    main()
