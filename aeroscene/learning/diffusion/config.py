"""Settings of the diffusion; you can read and check them without PyTorch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

from aeroscene.ranges import Range, require_ranges

ScheduleKind = Literal["linear", "cosine", "log_snr"]


class DiffusionError(ValueError):
    """A setting of the diffusion is out of range; one line has field, value and valid values."""


def require_choice(section: str, cfg: object, **choices: Any) -> None:
    """Require that fields hold members of their `Literal` types.

    Args:
        section: Name of the section in messages.
        cfg: Configuration whose fields are checked.
        **choices: `Literal` type of each field, by the name of the field.

    Raises:
        DiffusionError: If a field has another value.
    """
    for name, choice in choices.items():
        if getattr(cfg, name) not in get_args(choice):
            valid = ", ".join(get_args(choice))
            raise DiffusionError(f"{section}.{name} is {getattr(cfg, name)!r}; valid: {valid}")


@dataclass(frozen=True, kw_only=True)
class ScheduleCfg:
    """The noise schedule, which the paper leaves open."""

    kind: ScheduleKind = "cosine"
    """`linear`: variances of Ho et al. 2020. `cosine`: Nichol and Dhariwal 2021. `log_snr`: even
    steps of the logarithm of alpha_bar / (1 - alpha_bar), so that as many steps work on centimetres
    as on rooms."""
    n_steps: Annotated[int, Range(2, 10_000)] = 1000
    """Training steps T."""
    beta_first: float = 1e-4
    """First beta of `linear` for T = 1000; scaled by 1000/T, so any T ends in the same noise."""
    beta_last: float = 0.02
    """Last beta of `linear`, likewise."""
    log_snr_first: float = 12.0
    """Log signal-to-noise ratio of `log_snr` after the first step: noise of 0.25% of a spread."""
    log_snr_last: float = -7.0
    """And after the last one: the noise hides the layout."""

    def __post_init__(self) -> None:
        require_choice("schedule", self, kind=ScheduleKind)
        require_ranges(self, DiffusionError, "schedule.")
        # Betas are scaled to T, and each must stay a variance below 1.
        top = self.beta_last * 1000 / self.n_steps
        if self.kind == "linear" and not (0 < self.beta_first <= self.beta_last and top < 1):
            raise DiffusionError(
                f"schedule.beta_first and beta_last are {self.beta_first:g} and "
                f"{self.beta_last:g}; valid: 0 < first <= last < {self.n_steps / 1000:g}"
            )


Parameterisation = Literal["eps", "v", "x0"]

Variance = Literal["small", "large"]


@dataclass(frozen=True, kw_only=True)
class LossCfg:
    """Settings of the loss."""

    parameterisation: Parameterisation = "v"
    """Quantity that the network predicts; the paper: eps."""
    min_snr_gamma: Annotated[float | None, Range(0.0, is_above=True)] = None
    """Cap of min-SNR weighting; None weighs all times alike, as the paper."""
    weighting: Literal["even", "velocity"] = "even"
    """Weights of the times: `even` as the paper's; `velocity` weights an error of eps by
    1 / alpha_bar, at most 50, as if the velocity were predicted. With even weights, what is decided
    where there is much noise, such as which wall stands on which side, counts next to nothing."""
    is_stratified: bool = True
    """True spreads a batch's times evenly; the paper draws each on its own."""
    small_noise_share: Annotated[float, Range(0.0, 1.0)] = 0.0
    """Share of the times at which log sigma is uniform, see `Schedule.draw_time`. A place is
    learned to centimetres at low noise, of which uniform times have little; the paper: 0."""
    log_snr_mean: float | None = None
    """Mean of the log signal-to-noise ratio of a normal distribution that times are drawn by; None
    draws them evenly. Where the noise is below a tenth of a spread nearly all of it cannot be told
    from the layout, so that such times teach nothing; those of a uniform log SNR are 40%."""
    log_snr_spread: Annotated[float, Range(0.0, is_above=True)] = 2.0
    """Spread of that distribution."""
    log_snr_even_share: Annotated[float, Range(0.0, 1.0)] = 0.0
    """Share of the times that is even over the log ratio instead. Without any, no network is
    trained where sampling begins and ends, and it is worse there than a formula."""
    coarse_weight: Annotated[float, Range(0.0)] = 1.0
    """Weight of a coarse token's error relative to a fine token's. Everything stands on or in
    coarse objects, so their errors move all that they carry."""
    guide_weight: Annotated[float, Range(0.0)] = 0.0
    """The paper's lambda_guide, which it leaves open."""
    guide_scenes: Annotated[int | None, Range(1)] = None
    """Scenes of a batch on which L_guide is evaluated; None takes all. Times and scenes of a batch
    are random, so that its first scenes are a sample of it."""
    gate_weight: Annotated[float, Range(0.0)] = 0.0
    """Weight of the cross-entropy of tau with the known level. The paper has no such term: its hard
    threshold gives the gate no gradient."""

    def __post_init__(self) -> None:
        require_ranges(self, DiffusionError, "")


SamplerKind = Literal["ddpm", "ddim", "dpm-solver++"]

Spacing = Literal["time", "log_snr"]


@dataclass(frozen=True, kw_only=True)
class SamplerCfg:
    """Settings of the sampling of a layout."""

    kind: SamplerKind = "ddim"
    """`ddpm` is the paper's; `ddim` and `dpm-solver++` need fewer steps."""
    n_steps: Annotated[int, Range(1, 1000)] = 30
    """Calls of the network; the paper: 100."""
    parameterisation: Parameterisation = "v"
    """Quantity that the network predicts, as in its training."""
    spacing: Spacing = "time"
    """Steps of equal time, or of equal log signal-to-noise ratio and a last one to 0."""
    eta: Annotated[float, Range(0.0, 1.0)] = 0.0
    """Noise of `ddim`: 0 is deterministic but for the first noise, 1 is ancestral."""
    variance: Variance = "small"
    """Variance of `ddpm`."""

    def __post_init__(self) -> None:
        require_choice("sampler", self, kind=SamplerKind, parameterisation=Parameterisation)
        require_choice("sampler", self, spacing=Spacing, variance=Variance)
        require_ranges(self, DiffusionError, "sampler.")
