"""Environments of Gymnasium: machines that learn, or are controlled, to follow a path.

    import gymnasium
    import omnisim.gym

    one = gymnasium.make("omnisim/Follow-v0", scene="youbot", path="circle")
    many = gymnasium.make_vec("omnisim/Follow-v0", num_envs=64, scene="youbot", path="circle")

follow.py has the observation, the action and the reward; omnisim.gym.path makes paths of other sizes and speeds.
"""

from omnisim.gym.paths import path as path

try:
    from gymnasium.envs.registration import register
except ModuleNotFoundError:
    raise ImportError("omnisim.gym needs Gymnasium: pip install 'omnisim-engine[gym]'") from None

register(
    id="omnisim/Follow-v0",
    entry_point="omnisim.gym.single:FollowEnv",
    vector_entry_point="omnisim.gym.follow:FollowVectorEnv",
)
