"""What things stand beside: a cup beside a laptop or a plate, a shelf by another along the wall.

A writer says which of the things there a unit has its relation to, by rank, before any of them has
a place. So what is at that rank in the end may be what no such unit ever stood beside.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from aeroscene.learning.program.kinds import UnitKind

_LEAST_COUNT = 20
"""Bonds that occur less often may have any host."""
_LEAST_SHARE = 0.02
"""Hosts that a bond has less often it is not given."""

Bond = str
"""Category of a unit and how it is bound to its host."""
HostKey = str
"""Category of a host, and its own relation."""


def bond_of(kind: UnitKind) -> Bond:
    """The bond that a unit's kind has."""
    return f"{kind.category} {kind.relation} {kind.gap} {kind.align} {kind.turn}"


def host_key(category: str, relation: str) -> HostKey:
    """What a host is, and how it stands itself; the relation is empty where it is no unit."""
    return f"{category} {relation}"


@dataclass(frozen=True, slots=True)
class Companions:
    """Hosts by the bond of the unit that stands at them."""

    by_bond: Mapping[Bond, Collection[HostKey]] = field(default_factory=dict)

    def nearest(self, kind: UnitKind, rank: int, hosts: Sequence[HostKey]) -> int:
        """The rank nearest to the one that was drawn whose host a unit of a kind may have."""
        known = self.by_bond.get(bond_of(kind))
        fitting = [i for i, host in enumerate(hosts) if known is None or host in known]
        return min(fitting, key=lambda i: abs(i - rank), default=rank)


ANY_COMPANIONS = Companions()


def measure_companions(pairs: Sequence[tuple[UnitKind, HostKey]]) -> Companions:
    """The hosts of a corpus.

    Args:
        pairs: Every unit's kind, and its host.
    """
    counts: defaultdict[Bond, Counter[HostKey]] = defaultdict(Counter)
    for kind, host in pairs:
        counts[bond_of(kind)][host] += 1
    found: dict[Bond, tuple[HostKey, ...]] = {}
    for bond, hosts in sorted(counts.items()):
        n = hosts.total()
        if n >= _LEAST_COUNT:
            found[bond] = tuple(sorted(h for h, k in hosts.items() if k >= _LEAST_SHARE * n))
    return Companions(found)
