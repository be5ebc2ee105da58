"""Configuration of the denoiser's network, for all presets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from aeroscene.ranges import Range, require_ranges

N_GEOMETRY = 10
"""Channels of the paper's layout: p (3), q (4) and s (3)."""


_CHOICES = {
    "denoiser": ("unet", "tokens"),
    "routing": ("learned", "given"),
    "coarse_branch": ("cnn", "attention"),
    "fine_branch": ("radius_gnn", "siblings"),
}


_VOXELS = Range(2, 64)
N_TRUSTED = 11
"""Noises at which `ModelCfg.trust` has a row."""
_TRUST = Range(0.0, 1.0)

TrustRow = tuple[float, float, float, float]
"""Shares of places, heights, headings and extents, each 0 to 1."""


class ModelCfgError(ValueError):
    """No network can be made of a configuration."""


@dataclass(frozen=True, kw_only=True)
class ModelCfg:
    """Shape of a denoiser; the defaults are the default preset.

    Raises:
        ModelCfgError: If a number is out of range or parts do not fit together.
    """

    denoiser: Literal["unet", "tokens"] = "tokens"
    """The paper's UNet over a list, conditioned on F_attn; or a head on the tokens themselves."""
    routing: Literal["learned", "given"] = "given"
    """The paper's learned gate; or the level that the skeleton knows."""
    coarse_branch: Literal["cnn", "attention"] = "attention"
    """The paper's 3D CNN over a voxel grid; or attention among coarse tokens."""
    fine_branch: Literal["radius_gnn", "siblings"] = "siblings"
    """The paper's GNN over the radius graph; or attention among siblings."""
    channels: Annotated[int, Range(8, 4096)] = 19
    """Channels of a token."""
    n_kinds: Annotated[int, Range(1, 65536)] = 256
    """Kinds of the vocabulary; not read where the category is among the channels."""
    n_categories: Annotated[int, Range(0, 4086)] = 0
    """Number C of categories that the paper's network is given. It is 0 for the default preset,
    which is given kinds."""
    n_domains: Annotated[int, Range(1, 64)] = 3
    """Mixed, outdoor, indoor."""
    width: Annotated[int, Range(1, 4096)] = 128
    """Token width, the paper's d_m, which it leaves open."""
    blocks: Annotated[int, Range(1, 64)] = 4
    """Cross-scale blocks, the paper's L, which it leaves open: even top-down, odd bottom-up."""
    heads: Annotated[int, Range(1, 64)] = 4
    """Attention heads, even."""
    has_narrow_heads: bool = True
    """True lets half of the default's heads see close kin alone (`relations`)."""
    ffn_ratio: Annotated[int, Range(1, 16)] = 2
    """Hidden width of the default's FFN by `width`."""
    fourier_bands: Annotated[int, Range(0, 16)] = 6
    """Octaves of the Fourier features of a position, or of the faces of a box (paper); 0 leaves
    them out."""
    place_width: Annotated[int, Range(2, 256)] = 16
    """Width of the encoding of a place among siblings."""
    max_depth: Annotated[int, Range(1, 64)] = 16
    """Greatest depth that the default tells apart; deeper tokens count as this."""
    unet_widths: tuple[int, ...] = (128, 192, 256)
    """Width of each level of the UNet."""
    grid_shape: tuple[int, int, int] = (16, 16, 8)
    """Voxels of the coarse branch along x, y and z."""
    grid_channels: Annotated[int, Range(1, 1024)] = 32
    """Width of the features on the grid."""
    grid_reach: Annotated[float, Range(0.0, is_above=True)] = 2.25
    """Half the extent of the grid, in half extents of the site."""
    graph_radius: Annotated[float, Range(0.0, is_above=True)] = 0.25
    """The paper's delta_f, which it leaves open, m."""
    trust: tuple[TrustRow, ...] = ()
    """Share of the paper's network that is followed at each noise, from the most noise on. A
    training fits it at its end (`aeroscene.learning.paper.network.trust`). Empty follows it
    everywhere."""

    def __post_init__(self) -> None:
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                valid = ", ".join(map(repr, choices))
                raise ModelCfgError(f"{name} is {getattr(self, name)!r}; valid: {valid}")
        require_ranges(self, ModelCfgError, "")
        for voxels in self.grid_shape:
            _VOXELS.require("grid_shape", voxels, ModelCfgError)
        self._check_widths()
        if self.trust and len(self.trust) != N_TRUSTED:
            raise ModelCfgError(f"trust has {len(self.trust)} rows; valid: none, or {N_TRUSTED}")
        for share in (share for row in self.trust for share in row):
            _TRUST.require("trust", share, ModelCfgError)
        if self.denoiser == "tokens":
            self._check_tokens()

    def _check_widths(self) -> None:
        # Half of the heads are narrow, and encodings have sines and cosines.
        if self.heads % 2 or self.width % (2 * self.heads):
            raise ModelCfgError(
                f"heads is {self.heads} with width {self.width}; valid: an even number of which "
                "twice divides the width"
            )
        if self.place_width % 2:
            raise ModelCfgError(f"place_width is {self.place_width}; valid: even numbers, 2 to 256")
        if not self.unet_widths:
            raise ModelCfgError("unet_widths is (); valid: one width or more")
        # Attention at every level splits its width among the heads.
        for width in self.unet_widths:
            if width < 1 or width % self.heads:
                raise ModelCfgError(
                    f"unet_widths is {width}; valid: multiples of heads, {self.heads}"
                )
        # With categories the network reads the paper's ten channels.
        if self.n_categories and self.channels != N_GEOMETRY:
            raise ModelCfgError(
                f"channels is {self.channels} with n_categories {self.n_categories}; valid: "
                f"{N_GEOMETRY}"
            )

    def _check_tokens(self) -> None:
        parts = (self.routing, self.coarse_branch, self.fine_branch)
        if parts != ("given", "attention", "siblings"):
            raise ModelCfgError(
                f"routing, coarse_branch, fine_branch are {parts} with denoiser tokens; valid: "
                "('given', 'attention', 'siblings'); the other parts need denoiser unet"
            )
