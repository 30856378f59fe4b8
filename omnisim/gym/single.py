"""The same environment with one machine."""

from typing import Any, ClassVar

import numpy as np
from gymnasium import Env

from omnisim.gym.follow import FollowVectorEnv

OF_MANY = {"num_envs", "autoreset_mode", "threads"}


class FollowEnv(Env):
    """A machine that is to follow a path: a FollowVectorEnv of one machine that begins no episode by itself.

    It takes the same scene, path, vary and options, but for autoreset_mode and threads. Raises what that does.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(self, **options: Any):
        for name in OF_MANY & set(options):
            raise ValueError(f"option {name}: only for a vector environment, as gymnasium.make_vec makes it")
        self.many = FollowVectorEnv(1, **options, autoreset_mode="Disabled", threads=1)
        self.observation_space = self.many.single_observation_space
        self.action_space = self.many.single_action_space

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """The machine at the start of an episode."""
        super().reset(seed=seed)
        self.many.randoms[0] = self.np_random
        observed, _ = self.many.reset()
        return observed[0], {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """An action (A,), held for one control interval."""
        observed, rewards, terminated, truncated, infos = self.many.step(np.asarray(action)[None])
        info = {key: value[0] for key, value in infos.items() if not key.startswith("_")}
        return observed[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), info

    def close(self) -> None:
        self.many.close()
