"""Learn to hover: PPO of Stable-Baselines3 over 64 worlds, by velocities.

Needs pip install 'aeroscene[rl]'. Run: python examples/learn_hover.py
"""

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv

from aeroscene import EnvironmentCfg, make_vec, save_policy

CFG = EnvironmentCfg(action="velocity", action_hz=10)


class Worlds(VecEnv):
    """Our vector environment, as Stable-Baselines3 wants one."""

    set_attr = env_method = env_is_wrapped = None  # nobody asks

    def __init__(self, name: str, n: int, seed: int, **options) -> None:
        self.env, self.first_seed = make_vec(name, num_envs=n, **options), seed
        super().__init__(n, self.env.single_observation_space, self.env.single_action_space)

    def reset(self):
        return self.env.reset(seed=self.first_seed)[0]

    def step_async(self, actions) -> None:
        self.actions = actions

    def step_wait(self):
        observations, rewards, terminated, truncated, info = self.env.step(self.actions)
        infos: list[dict] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(terminated | truncated):
            infos[i] = {key: told[i] for key, told in info["final_info"].items()}
            infos[i] |= {"TimeLimit.truncated": truncated[i], "distance_m": info["distance_m"][i]}
            infos[i]["terminal_observation"] = info["final_obs"][i]
        return observations, rewards.astype(np.float32), terminated | truncated, infos

    def get_attr(self, attr_name: str, *_):
        return [getattr(self.env, attr_name, None)] * self.num_envs

    def close(self) -> None:
        self.env.close()

    def try_out(self, policy: PPO) -> list[dict]:
        """How the first episode of each world ends, without noise on the actions."""
        observations, ended = self.reset(), {}
        while len(ended) < self.num_envs:
            actions, _ = policy.predict(observations, deterministic=True)
            observations, _, is_done, infos = self.step(actions)
            ended = {i: infos[i] for i in np.flatnonzero(is_done)} | ended
        return list(ended.values())


def main(n_steps: int = 250_000, n: int = 64) -> tuple[float, float]:
    options = {"n_steps": 64, "batch_size": 16 * n, "n_epochs": 5, "gamma": 0.95}
    options |= {"policy_kwargs": {"log_std_init": -1.3}, "learning_rate": lambda left: 15e-4 * left}
    worlds, new_worlds = (Worlds("AeroScene/Hover-v0", n, seed, cfg=CFG) for seed in (0, 1_000_000))
    policy = PPO("MlpPolicy", worlds, seed=0, device="cpu", **options).learn(n_steps)
    save_policy(policy, "hover.zip", "AeroScene/Hover-v0", CFG)
    ended = [(each["is_success"], each["distance_m"]) for each in new_worlds.try_out(policy)]
    return tuple(np.mean(ended, axis=0).tolist())


if __name__ == "__main__":
    print("holds the target in {:.0%} of new episodes, {:.3f} m from it".format(*main()))
    print("Score it: aeroscene campaign --scenes 0:10 --pilot policy:hover.zip --out runs/hover")
