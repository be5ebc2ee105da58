"""Records of a partition as a tree: each with its children, and the token that it belongs to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from aeroscene.learning.program.records import n_children
from aeroscene.partition import Record

Token = TypeVar("Token")


@dataclass(slots=True, eq=False)
class Nested(Generic[Token]):
    """A record with its children, and the token that it belongs to, if any."""

    record: Record
    token: Token
    children: list[Nested[Token]] = field(default_factory=list)

    def flat(self) -> list[Record]:
        """Return all records in pre-order."""
        return [self.record, *(record for child in self.children for record in child.flat())]


def nest(records: Iterator[Record]) -> Nested[None]:
    """Read the next record of a sequence and everything below it."""
    record = next(records)
    return Nested(record, None, [nest(records) for _ in range(n_children(record))])


def cells(node: Nested[Token]) -> list[tuple[Token, int]]:
    """Return the tokens of the leaves in the order of `aeroscene.partition.cells.cells_of`.

    Each comes with the number of the piece, because a lane has a leaf on each piece of a bend.
    """
    return list(_cells(node))


def _cells(node: Nested[Token]) -> Iterator[tuple[Token, int]]:
    record, children = node.record, node.children
    match record.node:
        case "leaf":
            yield node.token, 0
        case "bend":
            lanes, banks = children[: record.rows], children[record.rows :]
            for piece in range(record.arity):
                # Piece by piece: first all lanes, then the two banks, as the partition builds them.
                yield from ((lane.token, piece) for lane in lanes)
                for bank in banks[2 * piece : 2 * piece + 2]:
                    yield from _cells(bank)
        case "cross" | "grid":
            # The first children of a grid hold its shares; cells come after them.
            yield from _all(children[record.arity + record.rows :])
        case _:
            yield from _all(children)


def _all(nodes: Sequence[Nested[Token]]) -> Iterator[tuple[Token, int]]:
    for node in nodes:
        yield from _cells(node)
