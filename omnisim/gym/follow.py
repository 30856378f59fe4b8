"""The environment omnisim/Follow-v0: machines that are to follow a path over time.

Observation, float64, of machine with pose p and twist, all along its own axes:

    0:3      error: the path's pose now, seen from the machine: x, y, m, and yaw, rad, within -pi and pi
    3:6      the path's twist now: m/s, m/s, rad/s
    6:9      the machine's own twist
    9:9+W    spin rates of its W wheels, rad/s
             normal forces of its wheels, N: W more with loads = True
             error against the path so many seconds later, 3 for each of `ahead`

Action, float32, within -1 and 1, by the option `action`: actions.py says what of. What is beyond is cut off.

Reward of a step, by the error (x, y, yaw) at its end and the option tolerance (d, a):

    exp(-(x^2 + y^2) / d^2 - yaw^2 / a^2)          between 0 and 1

An episode is truncated where the path ends, since the observation does not tell when that is. It is terminated where
the machine is further than `reach` from the path, and where the simulation cannot go on: info["status"] says why.
"""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from omnisim.gym import paths
from omnisim.gym.actions import actions, held_by, prepared
from omnisim.gym.instants import SPIN_RATES
from omnisim.gym.machines import Machines, OtherKind
from omnisim.gym.options import read
from omnisim.gym.variety import Variety
from omnisim.run.loop import stepped
from omnisim.scene.scene import Scene, SceneError, as_scene
from omnisim.studies.workers import cores


class FollowVectorEnv(VectorEnv):
    """So many machines, each with an episode of its own, marched by compiled code on all cores.

    scene    a Scene, or what `omnisim.load` takes
    path     a name, "line", "square", "circle" or "figure_eight", or a table (K, 4) of time, x, y and yaw in the world
             (s, m, m, rad), as `omnisim.gym.path` makes them; the machine starts as its scene says
    vary     a table [vary] of a study: keys of the scene, drawn anew for every episode of every machine
    options  options.py has them: action, limits, control, loads, ahead, reach, tolerance, autoreset_mode, threads

    Machine i draws from a generator of its own, seeded by `reset` with seed + i: its episodes are bit for bit those of
    a single environment with that seed, whatever the other machines do.

    Raises SceneError as `load` does and where the scene does not take such actions, ValueError for anything else that
    cannot be meant.
    """

    def __init__(
        self,
        num_envs: int = 1,
        scene: Scene | str | PathLike[str] = "youbot",
        path: str | Sequence[Sequence[float]] | np.ndarray = "circle",
        vary: Mapping[str, Any] | None = None,
        **options: Any,
    ):
        self.options = read(options)
        given = stepped(as_scene("omnisim/Follow-v0", scene))
        interval = 1.0 / self.options.control
        self.held = held_by(given.config, interval)
        self.path = paths.sampled(paths.checked(path), interval, self.options.ahead)
        self.actions = actions(given, self.options.action, self.options.limits)
        self.scene = prepared(given, self.options.action, self.path.steps * interval)
        self.variety = Variety(self.scene, vary)
        self.num_envs = num_envs
        self.machines = Machines(self.scene.config, num_envs, self.options.threads or cores())
        for key, config in self.variety.ends():
            self._put(np.array([0]), config, key)
        self.metadata = {"render_modes": [], "autoreset_mode": AutoresetMode(self.options.autoreset_mode)}
        self._spaces()
        self.randoms = [seeding.np_random()[0] for _ in range(num_envs)]
        self.step_of = np.zeros(num_envs, int)  # of each machine on the path
        self.over = np.ones(num_envs, bool)  # whose episode has ended, or has not begun

    def _spaces(self) -> None:
        wheels = len(self.scene.config.wheels)
        size = SPIN_RATES + wheels * (1 + self.options.loads) + 3 * len(self.options.ahead)
        self.single_observation_space = Box(-np.inf, np.inf, (size,), np.float64)
        self.single_action_space = Box(-1.0, 1.0, (len(self.actions.limits),), np.float32)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Every machine at the start of an episode; options["reset_mask"], (N,) booleans: only those.

        seed: of machine 0; those of the others follow it. Or one for each, None for a machine that goes on with its
        generator.
        """
        if isinstance(seed, int | np.integer):
            super().reset(seed=int(seed))
            seed = [int(seed) + i for i in range(self.num_envs)]
        seeds = [None] * self.num_envs if seed is None else seed
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed: must be one number, or {self.num_envs}, not {len(seeds)}")
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool:
            raise ValueError(f"options['reset_mask']: must be {self.num_envs} booleans")
        for i in np.flatnonzero(mask).tolist():
            if seeds[i] is not None:
                self.randoms[i] = seeding.np_random(seeds[i])[0]
        self._begin(mask)
        return self._observed(), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """An action (N, A) for every machine, held for one control interval.

        With autoreset_mode "NextStep" a machine whose episode has ended begins another, with no reward, instead of
        taking its action; with "Disabled" it stays as it is until it is reset.
        """
        actions = np.asarray(actions, float)
        if actions.shape != self.action_space.shape or not np.isfinite(actions).all():
            raise ValueError(f"actions: must be {self.action_space.shape} finite numbers")
        going = ~self.over
        again = self.over & (self.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP)
        if again.any():
            self._begin(again)
        self.machines.drive(going, self.actions.wheels, self.actions.of(actions))
        self.machines.march(going, self.held)
        self.step_of[going] += 1
        observed = self._observed()
        rewards = np.where(going, self._reward(observed), 0.0)
        failed = self.machines.failed
        lost = ~(np.hypot(observed[:, 0], observed[:, 1]) <= self.options.reach)
        terminated = (failed | lost) & ~again
        truncated = (self.step_of == self.path.steps) & ~terminated
        infos: dict[str, Any] = {}
        for i in np.flatnonzero(terminated & going).tolist():
            told = self.machines.sentence(i) if failed[i] else f"more than {self.options.reach:g} m off the path"
            infos = self._add_info(infos, {"status": told}, i)
        self.over = terminated | truncated
        return observed, rewards, terminated, truncated, infos

    def close_extras(self, **_: Any) -> None:
        self.machines.close()

    def _begin(self, who: np.ndarray) -> None:
        """An episode of each of these machines (N,)."""
        numbers, factors = np.flatnonzero(who), self.variety.factors
        if factors:
            for i in numbers.tolist():
                self._put(np.array([i]), self.variety.drawn(self.randoms[i]), ", ".join(f.key for f in factors))
        else:
            self._put(numbers, self.scene.config, "")
        self.step_of[who] = 0
        self.over[who] = False
        self.machines.march(who, 0)  # finds the rollers in contact

    def _put(self, who: np.ndarray, config: Any, keys: str) -> None:
        try:
            self.machines.put(who, config)
        except OtherKind as error:
            raise SceneError(f"<vary>: {keys}: makes machines of several kinds; {error}") from None

    def _observed(self) -> np.ndarray:
        """(N, observation)"""
        found = np.empty(self.observation_space.shape)
        self.machines.observe(self.path, self.step_of, self.options.loads, found)
        return found

    def _reward(self, observed: np.ndarray) -> np.ndarray:
        distance, angle = self.options.tolerance
        x, y, yaw = observed[:, :3].T
        return np.exp(-(x * x + y * y) / distance**2 - (yaw / angle) ** 2)
