"""Learn to land by velocities: PPO of Stable-Baselines3 over 64 worlds, judged as trials are.

Needs pip install 'aeroscene[rl]'. Run: python examples/learn_landing.py
"""

from collections import Counter

from learn_hover import Worlds
from stable_baselines3 import PPO

from aeroscene import EnvironmentCfg, save_policy

# Ten decisions a second: a landing is fifty of them, and exploring soon finds the ground.
CFG = EnvironmentCfg(action="velocity", action_hz=10)


def main(n_steps: int = 400_000, n: int = 64, n_trials: int = 100) -> Counter[str]:
    options = {"n_steps": 64, "batch_size": 16 * n, "n_epochs": 5, "gamma": 0.97}
    options |= {"learning_rate": lambda left: 1e-3 * left, "policy_kwargs": {"log_std_init": -0.7}}
    worlds = Worlds("AeroScene/Landing-v0", n, seed=0, cfg=CFG)
    policy = PPO("MlpPolicy", worlds, seed=0, device="cpu", **options).learn(n_steps)
    save_policy(policy, "landing.zip", "AeroScene/Landing-v0", CFG)
    new_worlds = Worlds("AeroScene/Landing-v0", n_trials, seed=1_000_000, cfg=CFG)
    return Counter(episode["code"] for episode in new_worlds.try_out(policy))


if __name__ == "__main__":
    for code, n_episodes in main().most_common():
        print(f"{n_episodes} of 100 new episodes: {code}")
    print(
        "Score it: aeroscene campaign --scenes 0:10 --pilot policy:landing.zip --out runs/landing"
    )
