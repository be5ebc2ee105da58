"""A policy of hand-made weights, which flies straight to its target: it needs no training."""

import io
import zipfile

import torch

from scenarios.environments import EnvironmentCfg, ObservationCfg
from scenarios.policies.description import Description, Network, write_description

CFG = EnvironmentCfg(action="velocity", action_hz=10)


def write_policy(path, task="landing", *, cfg=CFG, below_m=0.3, sign=1.0, name=None):
    """Write a Stable-Baselines3 file without its pickles, with its description.

    The velocity points to the target, at most 2 m/s across and 0.6 m/s up or down; `below_m` aims
    below the target, so that a landing touches the ground at some speed. With the sign -1 the
    policy flees.
    """
    first, last = torch.zeros(3, 18), torch.zeros(4, 3)
    for axis, (gain, share) in enumerate(((0.8, 0.4), (0.8, 0.4), (2.0, 0.2))):
        first[axis, axis], last[axis, axis] = gain, sign * share
    weights = {
        "one.weight": first,
        "one.bias": torch.tensor([0.0, 0.0, -2.0 * below_m]),
        "two.weight": last,
        "two.bias": torch.zeros(4),
    }
    packed = io.BytesIO()
    torch.save(weights, packed)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("policy.pth", packed.getvalue())
    write_description(
        path,
        Description(
            environment=name or f"AeroScene/{task.capitalize()}-v0",
            task=task,
            cfg=cfg,
            network=Network(layers=("one", "two"), activation="tanh"),
        ),
    )
    return path


ESTIMATED = EnvironmentCfg(
    action="velocity", action_hz=10, observation=ObservationCfg(state="estimated")
)
