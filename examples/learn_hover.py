"""Learn to hover: PPO of Stable-Baselines3 over 64 worlds, by thrust and body rates.

Needs pip install 'aeroscene[rl]' stable-baselines3. Run: python examples/learn_hover.py
"""

import gymnasium
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv

import scenarios.environments  # noqa: F401 - gymnasium knows the names now


class Worlds(VecEnv):
    """Our vector environment, as Stable-Baselines3 wants one."""

    set_attr = env_method = env_is_wrapped = None  # nobody asks

    def __init__(self, n: int, seed: int) -> None:
        self.env, self.first_seed = gymnasium.make_vec("AeroScene/Hover-v0", num_envs=n), seed
        self.ended: list[tuple[bool, float]] = []  # success and distance of each episode
        super().__init__(n, self.env.single_observation_space, self.env.single_action_space)

    def reset(self):
        return self.env.reset(seed=self.first_seed)[0]

    def step_async(self, actions) -> None:
        self.actions = actions

    def step_wait(self):
        observations, rewards, terminated, truncated, info = self.env.step(self.actions)
        infos: list[dict] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(terminated | truncated):
            infos[i]["terminal_observation"] = info["final_obs"][i]
            infos[i]["TimeLimit.truncated"] = bool(truncated[i])
            self.ended.append((info["final_info"]["is_success"][i], info["distance_m"][i]))
        return observations, rewards.astype(np.float32), terminated | truncated, infos

    def get_attr(self, attr_name: str, *_):
        return [getattr(self.env, attr_name, None)] * self.num_envs

    def close(self) -> None:
        self.env.close()


def main(n_steps: int = 2_000_000, n_worlds: int = 64) -> tuple[float, float]:
    options = {"n_steps": 64, "batch_size": 16 * n_worlds, "n_epochs": 5, "gamma": 0.985}
    options |= {"learning_rate": lambda left: 1e-3 * left, "policy_kwargs": {"log_std_init": -1.0}}
    policy = PPO("MlpPolicy", Worlds(n_worlds, 0), seed=0, device="cpu", **options)
    policy.learn(n_steps)
    new_worlds = Worlds(n_worlds, seed=1_000_000)
    observations = new_worlds.reset()
    while len(new_worlds.ended) < n_worlds:
        observations, *_ = new_worlds.step(policy.predict(observations, deterministic=True)[0])
    return tuple(np.mean(new_worlds.ended, axis=0).tolist())


if __name__ == "__main__":
    print("holds the target in {:.0%} of new episodes, {:.3f} m from it".format(*main()))
