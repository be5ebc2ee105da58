"""The writer's network, one element at a time, in NumPy.

Training runs whole programs through `aeroscene.learning.writer.model`. A draw adds one element at a
time, for which PyTorch would spend most of its time on calls. Keys and values of earlier elements
are kept, so each step costs one element only.

    symbol  name                                 shape
    w, k    width of an element, of a kind's vector
    h, d    heads, width of one                  w = h d

A test holds both implementations together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.special import erf
from torch import Tensor, nn

from aeroscene.learning.program.program import N_HOSTS, N_MEMBERS
from aeroscene.learning.writer.model import Block, Writer

Vector = Float[np.ndarray, " n"]
_USUAL_ELEMENTS = 512
"""Elements for which there is room at first."""


class StepwiseWriter:
    """A copy of a writer's weights."""

    def __init__(self, writer: Writer) -> None:
        """Copy the weights, and compute once what depends on kinds alone."""
        self.cfg = writer.cfg
        self.table = _array(writer.embedding())
        self._numbers = [
            _array(each.weight) for each in writer.numbers if isinstance(each, nn.Embedding)
        ]
        # Products of a kind's vector with fixed matrices: a look-up replaces them at each step.
        self._kind = self.table @ _array(writer.of_kind.weight).T + _array(writer.of_kind.bias)
        self._parent = self.table @ _array(writer.of_parent.weight).T + _array(
            writer.of_parent.bias
        )
        self.of_wish = _Linear(writer.of_wish)
        self.blocks = [_Block(block) for block in writer.blocks if isinstance(block, Block)]
        self._norm = _Norm(writer.norm)
        self.depth = _Mlp(writer.depth)
        self._count, self._at_depth = _array(writer.count.weight), _array(writer.at_depth.weight)
        self._choose_kind, self._rest = _Mlp(writer.kind), _Mlp(writer.rest)
        self._bias = _array(writer.bias)

    def begin(self, wish: Float[np.ndarray, " 6"]) -> Reading:
        """Return a reading of a program for a wish, before its first element."""
        return Reading(self, self.of_wish(wish))

    def element(self, seen: Sequence[int], of_wish: Vector) -> Vector:
        """Return an element as input of the first block.

        Args:
            seen: Its numbers, as `Lesson.seen`.
            of_wish: The wish, as the network embeds it.
        """
        x = self._kind[seen[0]] + self._parent[seen[1]] + of_wish
        for numbers, value in zip(self._numbers, seen[2:], strict=True):
            x += numbers[value]
        return x

    def known(self, x: Vector) -> Vector:
        """Return the features on which choices depend, from the output of the last block."""
        return self._norm(x)

    def local(
        self,
        known: Vector,
        above: Vector,
        above_kind: int,
        recent: Sequence[int],
        n_siblings: int,
        depth: int,
    ) -> Vector:
        """Return the features of a choice below some parent; see `Writer.local`."""
        siblings = self.table[[kind for kind in recent if kind >= 0]]
        none = np.zeros(self.table.shape[1], dtype=np.float32)
        latest, mean = (siblings[0], siblings.mean(0)) if len(siblings) else (none, none)
        numbers = self._count[n_siblings], self._at_depth[depth]
        return np.concatenate([known, above, self.table[above_kind], latest, mean, *numbers])

    def kind_logits(self, local: Vector, kinds: Int[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
        """Return the logits of some kinds.

        Only allowed kinds are computed, of which there are few among thousands.

        Args:
            local: Features of the choice.
            kinds: Numbers of the kinds.
        """
        # Not by BLAS, whose threads wait for each other actively at so tall a matrix.
        found = np.einsum("kd,d->k", self.table[kinds], self._choose_kind(local))
        return found + self._bias[kinds]

    def rest_logits(self, local: Vector, kind: int) -> list[Vector]:
        """Return the logits of member, host and array of a token of a kind."""
        found = self._rest(np.concatenate([local, self.table[kind]]))
        return np.split(found, [N_MEMBERS, N_MEMBERS + N_HOSTS])


class Reading:
    """Keys and values of every block, for the elements of one program that were read."""

    def __init__(self, writer: StepwiseWriter, of_wish: Vector) -> None:
        self._writer, self._of_wish = writer, of_wish
        heads = writer.cfg.heads
        shape = 2, len(writer.blocks), heads, _USUAL_ELEMENTS, writer.cfg.width // heads
        self._keys_and_values = np.zeros(shape, dtype=np.float32)
        self._n = 0

    def read(self, seen: Sequence[int], kin: Bool[np.ndarray, " t"]) -> Vector:
        """Return features after the next element.

        Args:
            seen: Its numbers, as `Lesson.seen`.
            kin: Elements that narrow heads see, itself included.
        """
        writer, n = self._writer, self._n
        # Room doubles when it is full.
        if n == self._keys_and_values.shape[3]:
            more = np.zeros_like(self._keys_and_values)
            self._keys_and_values = np.concatenate([self._keys_and_values, more], axis=3)
        x = writer.element(seen, self._of_wish)
        masked = np.where(kin, 0.0, -np.inf).astype(np.float32)
        for block, keys, values in zip(writer.blocks, *self._keys_and_values, strict=True):
            query, keys[:, n], values[:, n] = block.inward(x)
            scores = np.einsum("hd,htd->ht", query, keys[:, : n + 1])
            # The second half of the heads is narrow; no mask is needed for what comes later.
            scores[len(scores) // 2 :] += masked
            weights = np.exp(scores - scores.max(axis=1, keepdims=True))
            weights /= weights.sum(axis=1, keepdims=True)
            x = block.onward(x, np.einsum("ht,htd->hd", weights, values[:, : n + 1]).ravel())
        self._n += 1
        return writer.known(x)


class _Linear:
    def __init__(self, layer: nn.Linear) -> None:
        self._weight, self._bias = _array(layer.weight), _array(layer.bias)

    def __call__(self, x: Vector) -> Vector:
        return self._weight @ x + self._bias


class _Norm:
    def __init__(self, layer: nn.LayerNorm) -> None:
        self._weight, self._bias, self._eps = _array(layer.weight), _array(layer.bias), layer.eps

    def __call__(self, x: Vector) -> Vector:
        away = x - x.mean()
        spread = np.sqrt(np.square(away).mean() + np.float32(self._eps))
        return away / spread * self._weight + self._bias


class _Mlp:
    """Two layers with an exact GELU between them."""

    def __init__(self, layers: nn.Sequential) -> None:
        linear = [layer for layer in layers if isinstance(layer, nn.Linear)]
        self._inward, self._outward = (_Linear(layer) for layer in linear)

    def __call__(self, x: Vector) -> Vector:
        hidden = self._inward(x)
        return self._outward(hidden * (0.5 + 0.5 * erf(hidden * np.float32(math.sqrt(0.5)))))


class _Block:
    def __init__(self, block: Block) -> None:
        self._norm, self._norm_ffn = _Norm(block.norm), _Norm(block.norm_ffn)
        self._inward, self._outward = _Linear(block.inward), _Linear(block.outward)
        self._ffn = _Mlp(block.ffn)
        self._heads = block.heads

    def inward(self, x: Vector) -> Float[np.ndarray, "3 h d"]:
        """Return scaled query, key and value of an element."""
        packed = self._inward(self._norm(x)).reshape(3, self._heads, -1)
        packed[0] /= np.float32(math.sqrt(packed.shape[-1]))
        return packed

    def onward(self, x: Vector, mixed: Vector) -> Vector:
        """Return the element after attention and FFN."""
        x = x + self._outward(mixed)
        return x + self._ffn(self._norm_ffn(x))


def _array(value: Tensor) -> np.ndarray:
    return value.detach().float().cpu().numpy()
