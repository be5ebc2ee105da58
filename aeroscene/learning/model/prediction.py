"""What a denoiser says of a noisy layout."""

from __future__ import annotations

from typing import NamedTuple

from jaxtyping import Float
from torch import Tensor


class Prediction(NamedTuple):
    """Output of a `HierarchicalDenoiser`."""

    output: Float[Tensor, "batch n channels"]
    """Noise, velocity or clean layout, as the parameterisation has it; zero at padding."""
    tokenizability: Float[Tensor, "batch n"] | None
    """The paper's tau in [0, 1] of each token, 0 at padding; None where the routing is given."""
