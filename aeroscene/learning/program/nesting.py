"""Records of a partition as a tree: each with those right below it, and the token that it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from aeroscene.learning.program.records import n_children
from aeroscene.partition import Record

Token = TypeVar("Token")


@dataclass(slots=True, eq=False)
class Nested(Generic[Token]):
    """A record with its children; `token` is what it belongs to, if anything."""

    record: Record
    token: Token
    children: list[Nested[Token]] = field(default_factory=list)

    def flat(self) -> list[Record]:
        """All records in pre-order."""
        return [self.record, *(record for child in self.children for record in child.flat())]


def nest(records: Iterator[Record]) -> Nested[None]:
    """The next record of a sequence and what comes below it."""
    record = next(records)
    return Nested(record, None, [nest(records) for _ in range(n_children(record))])


def cells(node: Nested[Token]) -> list[tuple[Token, int]]:
    """Tokens of the leaves in the order of `aeroscene.partition.cells.cells_of`.

    With each comes the number of the piece where a lane has a leaf on each piece of a bend.
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
                yield from ((lane.token, piece) for lane in lanes)
                for bank in banks[2 * piece : 2 * piece + 2]:
                    yield from _cells(bank)
        case "cross" | "grid":
            yield from _all(children[record.arity + record.rows :])
        case _:
            yield from _all(children)


def _all(nodes: Sequence[Nested[Token]]) -> Iterator[tuple[Token, int]]:
    for node in nodes:
        yield from _cells(node)
