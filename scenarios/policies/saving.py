"""Saves a policy of Stable-Baselines3 so that trials can score it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scenarios.environments.cfg import EnvironmentCfg
from scenarios.environments.names import ENVIRONMENTS
from scenarios.policies.description import (
    ACTIVATIONS,
    Description,
    Network,
    PolicyError,
    Scaling,
    write_description,
)
from scenarios.policies.policy import read_policy

_FAMILIES = (
    # On-policy algorithms, then SAC, then TD3 and DDPG: where the layers of the actor are.
    (("mlp_extractor", "policy_net"), ("action_net",)),
    (("actor", "latent_pi"), ("actor", "mu")),
    (("actor", "mu"), ()),
)


def save_policy(
    model: Any,
    path: Path | str,
    environment: str,
    cfg: EnvironmentCfg | None = None,
    *,
    task: str | None = None,
) -> None:
    """Save a model of Stable-Baselines3, and its description beside it.

    `aeroscene campaign --pilot policy:FILE` then flies it through trials.

    Args:
        model: PPO, A2C, SAC, TD3 or DDPG with an `MlpPolicy`.
        path: File to write, such as landing.zip; the description is landing.json.
        environment: Environment that it was trained in, such as AeroScene/Landing-v0.
        cfg: Configuration of that environment; None is the default.
        task: Task of AeroScene/Offboard-v0; other environments have one of their own.

    Raises:
        PolicyError: If the model has another kind of network, or the environment is unknown.
        OSError: If a file cannot be written.
    """
    path = Path(path)
    network, scaling = _network_of(model.policy), _scaling_of(model)
    description = _described(environment, cfg, task, scaling, network)
    model.save(path)
    write_description(path, description)
    # What could not be flown must not be noticed only after the training is gone.
    read_policy(path)


def describe_policy(
    path: Path | str,
    environment: str,
    cfg: EnvironmentCfg | None = None,
    *,
    task: str | None = None,
) -> None:
    """Write the description of an ONNX file beside it; arguments are those of `save_policy`.

    Raises:
        PolicyError: If there is no such file or environment, or the file does not fit it.
        OSError: If it cannot be written.
    """
    write_description(Path(path), _described(environment, cfg, task, None, None))
    read_policy(Path(path))


def _described(
    environment: str,
    cfg: EnvironmentCfg | None,
    task: str | None,
    scaling: Scaling | None,
    network: Network | None,
) -> Description:
    if environment not in ENVIRONMENTS:
        valid = ", ".join(ENVIRONMENTS)
        raise PolicyError(f"environment is {environment!r}; valid: {valid}")
    own = ENVIRONMENTS[environment] or task
    if own is None or (task is not None and task != own):
        raise PolicyError(
            f"task of {environment} is {task!r}; valid: {own or 'hover, navigation, landing'}"
        )
    return Description(
        environment=environment,
        task=own,
        cfg=cfg or EnvironmentCfg(),
        scaling=scaling,
        network=network,
    )


def _network_of(policy: Any) -> Network:
    """Return the layers of a policy's actor in the order of their computation.

    Raises:
        PolicyError: If it has other layers than fully connected ones.
    """
    modules = dict(policy.named_modules())
    for trunk, head in _FAMILIES:
        names = [".".join(part) for part in (trunk, head) if part]
        if not all(name in modules for name in names):
            continue
        found = [(name, modules[name]) for name in _leaves(names, modules)]
        layers = tuple(name for name, module in found if type(module).__name__ == "Linear")
        others = {type(module).__name__.lower() for name, module in found if name not in layers}
        is_squashed = bool(getattr(policy, "squash_output", False)) or "actor" in modules
        # The last function of TD3's network is the squashing one.
        between = others - {"tanh"} if is_squashed and not head else others
        if layers and len(between) <= 1 and between <= set(ACTIVATIONS) and _is_flat(policy):
            activation: Any = next(iter(between), "relu" if is_squashed else "tanh")
            return Network(layers=layers, activation=activation, is_squashed=is_squashed)
    raise PolicyError(
        f"policy {type(policy).__name__} has no network of fully connected layers with one of "
        f"{', '.join(ACTIVATIONS)}; valid: MlpPolicy, or export another one to ONNX"
    )


def _leaves(names: Sequence[str], modules: dict[str, Any]) -> list[str]:
    return [
        name
        for part in names
        for name in modules
        if (name == part or name.startswith(f"{part}.")) and not list(modules[name].children())
    ]


def _is_flat(policy: Any) -> bool:
    extractor = getattr(policy, "features_extractor", None) or policy.actor.features_extractor
    return not list(extractor.parameters())


def _scaling_of(model: Any) -> Scaling | None:
    """Return the normalisation of observations that a model was trained with, if any."""
    normalised = model.get_vec_normalize_env()
    if normalised is None or not normalised.norm_obs:
        return None
    statistics = normalised.obs_rms
    return Scaling(
        mean=tuple(statistics.mean.tolist()),
        std=tuple(((statistics.var + normalised.epsilon) ** 0.5).tolist()),
        clip=float(normalised.clip_obs),
    )
