"""Draws from what the network says, within what the grammar allows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int
from torch import Tensor

from aeroscene.learning.skeleton.grammar import Grammar
from aeroscene.learning.skeleton.needs import Needs
from aeroscene.learning.skeleton.path import Paths


class Chooser:
    """Draws for many rows, each with a generator of its own.

    What a row gets depends on its own logits and generator only, not on which others there are.
    Temperatures of 0.85 and 0.9 and a nucleus of 0.95 measured like none: what grammar and needs
    forbid is the tail that such settings are for.
    """

    def __init__(self, generators: Sequence[np.random.Generator]) -> None:
        self._generators = generators

    def choose(
        self,
        rows: Int[np.ndarray, " r"],
        logits: Float[Tensor, "r choices"],
        allowed: Bool[np.ndarray, "r choices"],
    ) -> Int[np.ndarray, " r"]:
        """One of the allowed choices for each row; each row must have one."""
        # Above 0 and up to 1: so the first share that reaches it is never an empty one.
        uniform = np.array([1.0 - self._generators[row].random() for row in rows.tolist()])
        scaled = np.where(allowed, logits.cpu().double().numpy(), -np.inf)
        weight = np.exp(scaled - scaled.max(axis=1, keepdims=True))
        total = (weight / weight.sum(axis=1, keepdims=True)).cumsum(axis=1)
        return (total < uniform[:, None] * total[:, -1:]).sum(axis=1)


def allowed_children(
    grammar: Grammar,
    paths: Paths,
    rows: Int[np.ndarray, " r"],
    wanted: Bool[np.ndarray, "r kinds"],
    needs: Needs,
    n_left: Int[np.ndarray, " r"],
) -> Bool[np.ndarray, "r depths kinds"]:
    """Which kinds may come next at which depth, from 1: those that training had there.

    Where that leaves nothing, first what parents need is given up, then how often they may have a
    kind, and at last who may be whose child: the root may have everything that is wanted. See
    `Needs.affordable` for `n_left`.
    """
    cap = grammar.cap[paths.kind[rows, :-1]]
    seen = (cap > 0) & wanted[:, None]
    few_enough = seen & (paths.bag[rows, :-1] < cap)
    everything = np.zeros_like(seen)
    everything[:, 0] = wanted
    allowed = few_enough & needs.affordable(paths, rows, n_left)
    for instead in (few_enough, seen, everything):
        stuck = ~allowed.any(axis=(1, 2))
        allowed[stuck] = instead[stuck]
    return allowed
