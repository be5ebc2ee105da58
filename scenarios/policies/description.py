"""Description of a policy: what it observes, what its actions mean, how its network is laid out.

It lies beside the policy in a JSON file of the same name. Without it nobody could tell whether the
first of 18 numbers is a distance or a velocity, so a policy without one is refused.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import msgspec

from aeroscene.files import read_bounded, replacing
from aeroscene.files.bounds import MOST_CONFIG_BYTES
from scenarios.environments.cfg import EnvironmentCfg, ObservationCfg
from scenarios.environments.interface.observations import layout
from scenarios.environments.names import ENVIRONMENTS
from scenarios.environments.tasks import TASKS

Activation = Literal["tanh", "relu", "elu"]
FORMAT = 1
MOST_LAYERS = 16


class PolicyError(ValueError):
    """A policy cannot be used; one line names the file, the fault and what would be valid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Network:
    """Network of fully connected layers whose weights are in a Stable-Baselines3 file."""

    layers: tuple[str, ...]
    """Names of the layers, from observation to action: NAME.weight and NAME.bias are tensors."""
    activation: Activation = "tanh"
    """Function between two layers."""
    is_squashed: bool = False
    """True if the hyperbolic tangent follows the last layer, false if actions are clipped."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Scaling:
    """Normalisation that the observation gets first, as `VecNormalize` does it."""

    mean: tuple[float, ...]
    std: tuple[float, ...]
    clip: float
    """Greatest size of a normalised number."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Description:
    """Environment, observation and action that a policy was trained with."""

    environment: str
    """Environment by its name, such as AeroScene/Landing-v0."""
    task: str
    """Task of that environment: hover, navigation or landing."""
    cfg: EnvironmentCfg
    """Vehicle, meaning and rate of the actions, and parts of the observation."""
    scaling: Scaling | None = None
    network: Network | None = None
    """Network of a Stable-Baselines3 file; an ONNX file has its own."""


class _Facts(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    format: int
    environment: str
    task: str
    vehicle: str
    action: str
    action_hz: int
    observation: dict[str, Any]
    layout: list[tuple[str, int]]
    scaling: Scaling | None = None
    network: Network | None = None


def description_path(path: Path) -> Path:
    """Return the file beside a policy that describes it: landing.json beside landing.zip."""
    return path.with_suffix(".json")


def write_description(path: Path, description: Description) -> None:
    """Write the description of a policy beside it.

    Args:
        path: File of the policy.
        description: Its description.

    Raises:
        OSError: If it cannot be written.
    """
    cfg = description.cfg
    facts = _Facts(
        format=FORMAT,
        environment=description.environment,
        task=description.task,
        vehicle=cfg.vehicle,
        action=cfg.action,
        action_hz=cfg.action_hz,
        observation=asdict(cfg.observation),
        layout=layout(cfg.observation),
        scaling=description.scaling,
        network=description.network,
    )
    with replacing(description_path(path)) as file:
        file.write(json.dumps(msgspec.to_builtins(facts), indent=2).encode() + b"\n")


def read_description(path: Path) -> Description:
    """Read the description of a policy, whoever wrote it.

    Args:
        path: File of the policy.

    Raises:
        PolicyError: If it is missing, damaged, or describes something that does not exist here.
    """
    file = description_path(path)
    try:
        return _checked(msgspec.json.decode(read_bounded(file, MOST_CONFIG_BYTES), type=_Facts))
    except (OSError, ValueError, RecursionError) as error:
        raise PolicyError(
            f"description {str(file)!r} of policy {str(path)!r}: {' '.join(str(error).split())}; "
            "valid: what aeroscene.save_policy has written, see docs/learning.md"
        ) from None


def _checked(facts: _Facts) -> Description:
    """Return the description, its values checked.

    Raises:
        ValueError: Naming the field, its value and the valid ones.
    """
    _require("format", facts.format, (FORMAT,))
    _require("environment", facts.environment, tuple(ENVIRONMENTS))
    own_task = ENVIRONMENTS[facts.environment]
    _require("task", facts.task, tuple(TASKS) if own_task is None else (own_task,))
    given = dict(facts.observation)
    # JSON has lists where the configuration has tuples.
    for name in ("depth", "segments"):
        if isinstance(given.get(name), list):
            given[name] = tuple(given[name])
    cfg = EnvironmentCfg(
        vehicle=facts.vehicle,
        action=facts.action,  # type: ignore[arg-type] - the configuration checks it
        action_hz=facts.action_hz,
        observation=ObservationCfg(**given),
    )
    here = layout(cfg.observation)
    if facts.layout != here:
        raise ValueError(f"layout is {facts.layout}; valid for this observation: {here}")
    _check_scaling(facts.scaling, sum(size for _, size in here))
    if (network := facts.network) is not None and not 1 <= len(network.layers) <= MOST_LAYERS:
        raise ValueError(f"network has {len(network.layers)} layers; valid: 1 to {MOST_LAYERS}")
    return Description(
        environment=facts.environment,
        task=facts.task,
        cfg=cfg,
        scaling=facts.scaling,
        network=facts.network,
    )


def _check_scaling(scaling: Scaling | None, n: int) -> None:
    if scaling is None:
        return
    for name in ("mean", "std"):
        numbers = getattr(scaling, name)
        if len(numbers) != n or not all(map(math.isfinite, numbers)):
            raise ValueError(f"scaling.{name} has {len(numbers)} numbers; valid: {n} finite ones")
    if not all(std > 0.0 for std in scaling.std) or not scaling.clip > 0.0:
        raise ValueError("scaling.std and scaling.clip: above 0 is valid")


def _require(name: str, value: object, valid: tuple[object, ...]) -> None:
    if value not in valid:
        raise ValueError(f"{name} is {value!r}; valid: {', '.join(map(str, valid))}")


ACTIVATIONS: tuple[str, ...] = get_args(Activation)
"""Names of the functions between layers."""
