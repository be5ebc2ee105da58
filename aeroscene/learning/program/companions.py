"""Hosts that units stand beside: a cup beside a laptop or a plate, a shelf beside another shelf.

The writer names the host of a unit by rank, before any object has a place. After decoding, that
rank may belong to an object that no such unit ever stands beside. The nearest rank with a suitable
host then counts instead.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from aeroscene.learning.program.kinds import UnitKind

_LEAST_COUNT = 20
"""Bonds that occur less often may have any host."""
_LEAST_SHARE = 0.02
"""Hosts with a smaller share of a bond are not suitable."""

Bond = str
"""Category of a unit and its relation to its host, as text."""
HostKey = str
"""Category of a host and its own relation, as text."""


def bond_of(kind: UnitKind) -> Bond:
    """Return the bond of a unit's kind."""
    return f"{kind.category} {kind.relation} {kind.gap} {kind.align} {kind.turn}"


def host_key(category: str, relation: str) -> HostKey:
    """Return the key of a host; the relation is empty if the host is no unit."""
    return f"{category} {relation}"


@dataclass(frozen=True, slots=True)
class Companions:
    """Suitable hosts, by the bond of the unit that stands at them."""

    by_bond: Mapping[Bond, Collection[HostKey]] = field(default_factory=dict)

    def nearest(self, kind: UnitKind, rank: int, hosts: Sequence[HostKey]) -> int:
        """Return the rank nearest to a drawn one whose host is suitable.

        Args:
            kind: Kind of the unit.
            rank: Rank that was drawn.
            hosts: Hosts by rank.

        Returns:
            A rank among the hosts, or the drawn one if no host is suitable.
        """
        known = self.by_bond.get(bond_of(kind))
        fitting = [i for i, host in enumerate(hosts) if known is None or host in known]
        return min(fitting, key=lambda i: abs(i - rank), default=rank)


ANY_COMPANIONS = Companions()


def measure_companions(pairs: Sequence[tuple[UnitKind, HostKey]]) -> Companions:
    """Count the hosts of a corpus.

    Args:
        pairs: Kind of every unit, and its host.
    """
    counts: defaultdict[Bond, Counter[HostKey]] = defaultdict(Counter)
    for kind, host in pairs:
        counts[bond_of(kind)][host] += 1
    found: dict[Bond, tuple[HostKey, ...]] = {}
    for bond, hosts in sorted(counts.items()):
        n = hosts.total()
        if n >= _LEAST_COUNT:
            # Sorted, so that equal corpora give equal checkpoints.
            found[bond] = tuple(sorted(h for h, k in hosts.items() if k >= _LEAST_SHARE * n))
    return Companions(found)
