"""The writer's network: a causal transformer over the elements of growing programs.

    depth   p(depth of the next token | elements so far)
    kind    p(its kind | depth, its parent, its latest siblings)
    rest    p(member, host, array | kind)

Half of the heads see all elements before. The other half see kin alone, which are the elements
above and the siblings, so that they need not learn the tree from a sequence.
"""

from __future__ import annotations

import numpy as np
import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.nn import functional

from aeroscene.learning.program.program import N_HOSTS, N_MEMBERS
from aeroscene.learning.program.vocabulary import ProgramVocabulary
from aeroscene.learning.writer.batch import LessonBatch
from aeroscene.learning.writer.bucket import N_BUCKETS
from aeroscene.learning.writer.config import WriterCfg
from aeroscene.learning.writer.embedding import KindEmbedding
from aeroscene.learning.writer.growth import MAX_DEPTH
from aeroscene.learning.writer.language import Language
from aeroscene.learning.writer.lesson import N_WISHES

# Width of the embeddings of counts and depths that a choice reads.
_SMALL = 12


def program_traits(vocabulary: ProgramVocabulary) -> Bool[Tensor, "kinds traits"]:
    """Return the traits of each kind as a matrix of flags."""
    names = sorted(set().union(*vocabulary.traits))
    column = {name: index for index, name in enumerate(names)}
    has_trait = np.zeros((len(vocabulary.traits), len(names)), dtype=bool)
    for row, traits in zip(has_trait, vocabulary.traits, strict=True):
        row[[column[name] for name in traits]] = True
    # As an array first: PyTorch takes a quarter of a second to make a tensor of so many lists.
    return torch.from_numpy(has_trait)


class Block(nn.Module):
    """Masked attention and FFN, each after a normalisation."""

    def __init__(self, cfg: WriterCfg) -> None:
        super().__init__()
        self.heads = cfg.heads
        self.norm, self.norm_ffn = nn.LayerNorm(cfg.width), nn.LayerNorm(cfg.width)
        self.inward = nn.Linear(cfg.width, 3 * cfg.width)
        self.outward = nn.Linear(cfg.width, cfg.width)
        self.ffn = nn.Sequential(
            nn.Linear(cfg.width, cfg.ffn_ratio * cfg.width),
            nn.GELU(),
            nn.Dropout(cfg.dropout),
            nn.Linear(cfg.ffn_ratio * cfg.width, cfg.width),
        )
        self.drop = nn.Dropout(cfg.dropout)

    def forward(
        self,
        x: Float[Tensor, "b t w"],
        mask: Bool[Tensor, "b h t t"],
    ) -> Float[Tensor, "b t w"]:
        """Update the elements; `mask` is True for keys that a query sees."""
        packed = self.inward(self.norm(x)).unflatten(-1, (3, self.heads, -1))
        query, key, value = packed.permute(2, 0, 3, 1, 4).unbind(0)
        mixed = functional.scaled_dot_product_attention(query, key, value, attn_mask=mask)
        x = x + self.drop(self.outward(mixed.transpose(1, 2).flatten(-2)))
        return x + self.drop(self.ffn(self.norm_ffn(x)))


class Writer(nn.Module):
    """Draws programs by wish.

    `aeroscene.learning.writer.stepwise` computes the same in NumPy, for drawing.

    Args:
        cfg: Shape of the network.
        traits: Traits of each kind.
        n_shapes: Number of arrays in the vocabulary.
    """

    def __init__(self, cfg: WriterCfg, traits: Bool[Tensor, "kinds traits"], n_shapes: int) -> None:
        super().__init__()
        self.cfg = cfg
        width, kind = cfg.width, cfg.kind_width
        self.embedding = KindEmbedding(traits, kind)
        # One table for each column of `Lesson.seen` from the third on, in its order.
        sizes = (MAX_DEPTH, 64, 2, N_MEMBERS, N_HOSTS, n_shapes, N_BUCKETS, N_BUCKETS, N_BUCKETS, 2)
        self.numbers = nn.ModuleList(nn.Embedding(size, width) for size in sizes)
        self.of_kind = nn.Linear(kind, width)
        self.of_parent = nn.Linear(kind, width)
        self.of_wish = nn.Linear(N_WISHES, width)
        self.blocks = nn.ModuleList(Block(cfg) for _ in range(cfg.layers))
        self.norm = nn.LayerNorm(width)
        self.depth = _mlp(width, width, MAX_DEPTH, cfg.dropout)
        self.count = nn.Embedding(N_BUCKETS, _SMALL)
        self.at_depth = nn.Embedding(MAX_DEPTH, _SMALL)
        local = 2 * width + 3 * kind + 2 * _SMALL
        self.kind = _mlp(local, 2 * width, kind, cfg.dropout)
        self.bias = nn.Parameter(torch.zeros(len(traits)))
        self.rest = _mlp(local + kind, width, N_MEMBERS + N_HOSTS + n_shapes, cfg.dropout)
        self.n_shapes = n_shapes

    def forward(self, lesson: LessonBatch) -> dict[str, Float[Tensor, ""]]:
        """Return `surprise` for a batch."""
        return surprise(self, lesson)

    def read(
        self,
        seen: Int[Tensor, "b t 12"],
        wish: Float[Tensor, "b 6"],
        mask: Bool[Tensor, "b 2 t t"],
        table: Float[Tensor, "kinds_and_none k"],
    ) -> Float[Tensor, "b t w"]:
        """Return features after each element.

        Args:
            seen: Numbers of the elements, as `Lesson.seen`.
            wish: Numbers of the wishes.
            mask: Keys of wide heads, then of narrow ones.
            table: Vectors of all kinds, as the embedding returns them.
        """
        x = self.of_kind(table[seen[..., 0]]) + self.of_parent(table[seen[..., 1]])
        x = x + self.of_wish(wish).unsqueeze(1)
        for column, numbers in enumerate(self.numbers, 2):
            x = x + numbers(seen[..., column])
        heads = mask.repeat_interleave(self.cfg.heads // 2, dim=1)
        for block in self.blocks:
            x = block(x, heads)
        return self.norm(x)

    def local(
        self,
        known: Float[Tensor, "n w"],
        above: Float[Tensor, "n w"],
        above_kind: Int[Tensor, " n"],
        recent: Int[Tensor, "n recent"],
        n_siblings: Int[Tensor, " n"],
        depth: Int[Tensor, " n"],
        table: Float[Tensor, "kinds_and_none k"],
    ) -> Float[Tensor, "n l"]:
        """Return the features on which the choice of a token below some parent depends.

        Args:
            known: Features after the latest element.
            above: Features after the parent.
            above_kind: Kind of the parent.
            recent: Kinds of its latest children, the last one first; -1 for none.
            n_siblings: Class of their number.
            depth: Depth of the token.
            table: Vectors of all kinds.
        """
        # Index -1 selects the row of "no kind"; the product removes it.
        siblings = table[recent] * (recent >= 0).unsqueeze(-1)
        mean = siblings.sum(1) / (recent >= 0).sum(1, keepdim=True).clamp(min=1)
        parts = [known, above, table[above_kind], siblings[:, 0], mean]
        return torch.cat([*parts, self.count(n_siblings), self.at_depth(depth)], dim=-1)

    def kind_logits(
        self, local: Float[Tensor, "n l"], table: Float[Tensor, "kinds_and_none k"]
    ) -> Float[Tensor, "n kinds"]:
        """Return the logits of all kinds.

        Args:
            local: Features of the choice.
            table: Vectors of all kinds; the last row, "no kind", is left out.
        """
        # Scores are products with the kinds' own vectors, so that rare kinds
        # profit from shared traits.
        return self.kind(local) @ table[:-1].T + self.bias

    def rest_logits(
        self,
        local: Float[Tensor, "n l"],
        kind: Int[Tensor, " n"],
        table: Float[Tensor, "kinds_and_none k"],
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Return the logits of member, host and array of tokens of some kinds.

        Args:
            local: Features of the choice.
            kind: Kinds that were chosen.
            table: Vectors of all kinds.
        """
        found = self.rest(torch.cat([local, table[kind]], dim=-1))
        member, host, shape = found.split([N_MEMBERS, N_HOSTS, self.n_shapes], dim=-1)
        return member, host, shape


def _mlp(inward: int, hidden: int, outward: int, dropout: float) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inward, hidden), nn.GELU(), nn.Dropout(dropout), nn.Linear(hidden, outward)
    )


def new_writer(cfg: WriterCfg, language: Language) -> Writer:
    """Return a writer of a language, with its first weights.

    They come from PyTorch's global generator, which the caller seeds.
    """
    vocabulary = language.vocabulary
    return Writer(cfg, program_traits(vocabulary), len(vocabulary.shapes))


def surprise(writer: Writer, lesson: LessonBatch) -> dict[str, Float[Tensor, ""]]:
    """Negative log-likelihood of a batch of programs, nats in all, by symbol."""
    return {
        name: functional.cross_entropy(logits, said, reduction="sum")
        for name, (logits, said) in _choices(writer, lesson).items()
    }


def shares_of_likeliest(writer: Writer, lesson: LessonBatch) -> Float[Tensor, " n"]:
    """Return how likely each kind in a batch was, over the likeliest one in its place.

    The threshold of the draws, `WriterCfg.least_share`, is compared with these shares.
    """
    logits, said = _choices(writer, lesson)["kind"]
    return torch.exp(logits.gather(1, said.unsqueeze(1))[:, 0] - logits.amax(1))


def _choices(writer: Writer, lesson: LessonBatch) -> dict[str, tuple[Tensor, Tensor]]:
    """Return the logits of every choice in a batch of programs, and the right choices."""
    table = writer.embedding()
    n = lesson.seen.shape[1]
    before = torch.ones(n, n, dtype=torch.bool, device=lesson.kin.device).tril()
    mask = torch.stack([before.expand_as(lesson.kin), lesson.kin & before], dim=1)
    known = writer.read(lesson.seen, lesson.wish, mask, table)
    places = lesson.kind >= 0
    row, _ = torch.nonzero(places, as_tuple=True)
    above = lesson.above[places]
    local = writer.local(
        known[places],
        known[row, above],
        lesson.seen[row, above, 0],
        lesson.recent[places],
        lesson.n_siblings[places],
        lesson.depth[places],
        table,
    )
    kind = lesson.kind[places]
    member, host, shape = writer.rest_logits(local, kind, table)
    said = lesson.depth >= 0
    return {
        "depth": (writer.depth(known[said]), lesson.depth[said]),
        "kind": (writer.kind_logits(local, table), kind),
        "member": (member, lesson.member[places]),
        "host": (host, lesson.host[places]),
        "shape": (shape, lesson.shape[places]),
    }
