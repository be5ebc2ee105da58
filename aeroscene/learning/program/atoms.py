"""Numbers that come back exactly: a door is 2.35 or 2.85 m high, and nothing between.

A diffusion model blurs such numbers. Therefore a drawn number near an atom is put on it. An atom
reaches as far as training has little else around it.

    symbol  meaning                                                                       value
    a       an atom: a value that a channel of a group has exactly, and often             -
    r_a     its reach: of the training values within it, at least a share q are the atom  -
    q       purity                                                                        0.95

Nothing else is moved, so that free quantities stay free.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

_SAME = 1e-3
"""Values that differ by less are the same: a millimetre, or a thousandth of a size."""
_LEAST_COUNT, _LEAST_SHARE = 4, 0.02
"""Least number and least share of the occurrences of an atom."""
_PURITY = 0.95

Reaches = tuple[np.ndarray, np.ndarray]
"""Atoms of one channel, rising, and the reach of each."""


@dataclass(frozen=True, eq=False)
class Atoms:
    """The atoms of a corpus, by group of kinds (`references.group_of`) and channel."""

    by_group: Mapping[Hashable, Mapping[int, Reaches]]

    def snap(self, group: Hashable, row: Float[np.ndarray, " channels"]) -> None:
        """Put the channels of a token on atoms near them, in place.

        Args:
            group: Group of the token's kind.
            row: Its channels; NaN where it has none.
        """
        for channel, (values, reaches) in self.by_group.get(group, {}).items():
            away = np.abs(values - row[channel])
            nearest = int(np.argmin(away))
            # A channel that is NaN fails this comparison and stays.
            if away[nearest] <= reaches[nearest]:
                row[channel] = values[nearest]


NO_ATOMS = Atoms({})


def atoms_of(rows: Float[np.ndarray, "k channels"], channels: Sequence[int]) -> dict[int, Reaches]:
    """Find the atoms of a group's rows in some channels.

    Args:
        rows: Channels of all tokens of the group; NaN where a token has none.
        channels: Channels in which to look.

    Returns:
        Atoms and reaches by channel; channels without atoms are absent.
    """
    found: dict[int, Reaches] = {}
    for channel in channels:
        values = rows[~np.isnan(rows[:, channel]), channel]
        reaches = _reaches(np.sort(values)) if len(values) >= _LEAST_COUNT else None
        if reaches is not None:
            found[channel] = reaches
    return found


def _reaches(values: Float[np.ndarray, " k"]) -> Reaches | None:
    """Find the atoms among rising values, and how far each reaches; None if there are none."""
    # Runs of values whose neighbours differ by a millimetre at most.
    runs = np.split(values, np.flatnonzero(np.diff(values) > _SAME) + 1)
    least = max(_LEAST_COUNT, _LEAST_SHARE * len(values))
    often = [run for run in runs if len(run) >= least and run[-1] - run[0] <= _SAME]
    # A channel with one value alone is constant, and needs no atom.
    if not often or (len(often) == 1 and len(runs) == 1):
        return None
    rest = np.concatenate([np.zeros(0), *(run for run in runs if not any(run is o for o in often))])
    atoms = np.array([run[len(run) // 2] for run in often])
    pairs = zip(atoms.tolist(), often, strict=True)
    return atoms, np.array([_pure_reach(atom, len(run), rest) for atom, run in pairs])


def _pure_reach(atom: float, count: int, rest: Float[np.ndarray, " k"]) -> float:
    """Distance at which other values begin to exceed the share that the purity allows."""
    away = np.sort(np.abs(rest - atom))
    # From count / (count + k) >= q: so many other values may lie within the reach.
    most = int(count * (1 - _PURITY) / _PURITY)
    return float(away[most]) if most < len(away) else np.inf
