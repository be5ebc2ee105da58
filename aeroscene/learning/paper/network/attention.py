"""The paper's Cross-scale Progressive Attention, and the masked attention that it consists of."""

from __future__ import annotations

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn

from aeroscene.learning.model.hierarchy import attend
from aeroscene.learning.paper.network.routing import Routes


class MaskedAttention(nn.Module):
    """F' = FC(Attn(LN Q, LN K, LN V)) + F, the paper's block, over keys that a mask allows.

    Args:
        width: Width of queries.
        heads: Attention heads; they divide `width`.
        key_width: Width of keys and values; None is `width`.
    """

    def __init__(self, width: int, heads: int, key_width: int | None = None) -> None:
        super().__init__()
        key_width = width if key_width is None else key_width
        self.heads = heads
        self.query_norm = nn.LayerNorm(width)
        self.key_norm = nn.LayerNorm(key_width)
        self.value_norm = nn.LayerNorm(key_width)
        self.query = nn.Linear(width, width)
        # A bias of keys adds the same to all logits of a query, which softmax cancels.
        self.key = nn.Linear(key_width, width, bias=False)
        self.value = nn.Linear(key_width, width)
        self.fc = nn.Linear(width, width)

    def forward(
        self,
        feature: Float[Tensor, "batch q d"],
        source: Float[Tensor, "batch k e"],
        is_allowed: Bool[Tensor, "batch queries k"],
        source_weight: Float[Tensor, "batch k 1"] | None = None,
        bias: Float[Tensor, "batch heads q k"] | None = None,
    ) -> Float[Tensor, "batch q d"]:
        """Let features ask a source.

        Args:
            feature: Q, and the residual F.
            source: K and V.
            is_allowed: Keys that each query sees. A query without any key stays as it is; one row
                serves all queries.
            source_weight: Weights of 1 that carry the gate's gradient.
            bias: Added to the logits.
        """
        has_key = is_allowed.any(-1, keepdim=True)
        value = self.value(self.value_norm(source))
        if source_weight is not None:
            value = value * source_weight
        # A row of False alone would give NaN, so it sees everything; its result is dropped below.
        is_seen = (is_allowed | ~has_key).unsqueeze(1)
        logit = feature.new_zeros(()) if bias is None else bias
        lowest = torch.finfo(logit.dtype).min
        shape = (len(feature), self.heads, feature.shape[1], source.shape[1])
        mask = logit.expand(shape).masked_fill(~is_seen, lowest)
        found = attend(
            self._to_heads(self.query(self.query_norm(feature))),
            self._to_heads(self.key(self.key_norm(source))),
            self._to_heads(value),
            mask,
        )
        return feature + self.fc(found) * has_key

    def _to_heads(self, packed: Float[Tensor, "batch n d"]) -> Float[Tensor, "batch h n e"]:
        return packed.unflatten(-1, (self.heads, -1)).transpose(1, 2)


class CrossScaleProgressiveAttention(nn.Module):
    """L blocks that alternate: fine tokens ask coarse ones, coarse tokens ask fine ones.

    Tokens of both scales keep their places in one tensor. The paper's concatenation of the outputs
    is therefore already there, and the projection follows.
    """

    def __init__(self, width: int, heads: int, blocks: int) -> None:
        super().__init__()
        self.blocks = nn.ModuleList(MaskedAttention(width, heads) for _ in range(blocks))
        self.project = nn.Linear(width, width)

    def forward(
        self, feature: Float[Tensor, "batch n d"], routes: Routes
    ) -> Float[Tensor, "batch n d"]:
        """Return F_attn of the features of both branches."""
        for i, block in enumerate(self.blocks):
            top_down = i % 2 == 0
            is_key = routes.is_coarse if top_down else routes.is_fine
            key_weight = routes.coarse_weight if top_down else routes.fine_weight
            asks = routes.fine_weight if top_down else routes.coarse_weight
            asked = block(feature, feature, is_key.unsqueeze(1), key_weight)
            # Only tokens of the asking scale change; the weight also passes the gate's gradient on.
            feature = feature + asks * (asked - feature)
        return self.project(feature)


class ScaleAttention(nn.Module):
    """Within-scale mixing by attention, in place of the paper's CNN or GNN (an ablation).

    Args:
        width: Width of a token.
        heads: Attention heads; they divide `width`.
        of_siblings: True lets tokens see only those of the same parent.
    """

    def __init__(self, width: int, heads: int, of_siblings: bool) -> None:
        super().__init__()
        self.of_siblings = of_siblings
        self.attention = MaskedAttention(width, heads)

    def forward(
        self,
        token: Float[Tensor, "batch n d"],
        is_member: Bool[Tensor, "batch n"],
        parent: Int[Tensor, "batch n"],
    ) -> Float[Tensor, "batch n d"]:
        """Return features of all tokens, which see the members of the scale.

        Args:
            token: Features of all tokens.
            is_member: True for tokens of the scale, which may be keys.
            parent: Slot of each token's parent.
        """
        is_allowed = is_member.unsqueeze(1)
        if self.of_siblings:
            is_allowed = is_allowed & (parent.unsqueeze(1) == parent.unsqueeze(2))
        return self.attention(token, token, is_allowed)
