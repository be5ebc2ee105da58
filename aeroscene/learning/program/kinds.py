"""Kinds of tokens: everything discrete about a record of a partition or a unit, in one symbol.

A unit's kind names its category and its relation to its host; a record's kind names its node and
how it divides. One symbol for all of it means that one softmax draws combinations that occur, and
never others. Three small numbers stay outside, in `aeroscene.learning.program.program.Program`: the
rank of the host, the array of a group, and the object of the parent's token that bears the token.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args, get_type_hints

import msgspec

from aeroscene.partition import Record
from aeroscene.relations.relation import Align, Gap, Relation
from aeroscene.relations.relation import Kind as RelationKind
from aeroscene.scene import AttributeValue, ObjectDomain, SceneObject
from aeroscene.scene.catalogue import CATALOGUE

# The order is that of the channels 10 to 16.
OPENINGS: tuple[str, ...] = (
    "door_m",
    "door_offset_m",
    "door_height_m",
    "window_m",
    "window_offset_m",
    "window_sill_m",
    "window_height_m",
)
"""Continuous attributes of objects with a shell."""
SHAPING = ("form", "is_enterable", "is_start", "rows", "storeys", "use", "zebra_end")
"""Discrete attributes that decide the shape of an object; the others are its looks."""
Attributes = tuple[tuple[str, AttributeValue], ...]
What = tuple[str, str, Attributes]
"""Category, domain and shaping attributes. Objects with an equal key look alike."""
Flag = Literal[0, 1]
FLAGS = {"is_inset", "is_mirrored", "is_placed"}
"""Flags of records, which are numbers in the JSON of kinds."""
NODES = frozenset({"leaf", "slice", "cross", "grid", "pinwheel", "overlay", "bend"})
"""Nodes of trees."""
AsLast = Literal["", "size", "plan", "height"]
AS_LAST_AXES: Mapping[AsLast, tuple[int, ...]] = {
    "size": (0, 1, 2),
    "plan": (0, 1),
    "height": (2,),
    "": (),
}
"""Axes of the extents that copy the last ones. The name with the most axes comes first, because the
first that holds is taken."""


class Kind(msgspec.Struct, frozen=True, omit_defaults=True):
    """Kind of a token: tokens of one kind differ in numbers and looks only.

    This class serves scenes and widths; the other nodes have subclasses with further fields.
    """

    node: str
    """Node of `aeroscene.partition.sequences.record`, or `scene`, `unit` or `member`."""
    category: str = ""
    """Category of a unit, leaf or lane. A width has that of its first user, a segment its own
    kind."""
    domain: str = ""
    """Domain of an object, `indoor` or `outdoor`; a scene has its own."""
    attributes: Attributes = ()
    """Attributes that decide the shape, sorted by name; a scene has its theme here."""

    # Defaults for every kind, so that a caller can read these from any kind.
    # Subclasses make fields of some.
    strip, turn, relation = 0, 0, ""
    is_turned, is_even, is_root, is_group = False, False, False, False

    @property
    def what(self) -> What:
        """Key under which objects share looks, and may copy the extents of the last one."""
        return self.category, self.domain, self.attributes

    @property
    def is_coarse(self) -> bool:
        """True if the token belongs to the coarse part of a skeleton."""
        return self.node not in {"unit", "member"} or CATEGORY_IS_COARSE.get(self.category, False)

    def traits(self) -> set[str]:
        """Return a word for each field that is not empty, and for each attribute."""
        # Fields at their defaults are left out, so that absent properties are no traits.
        said = msgspec.to_builtins(self)
        # Each opening is a trait of its own.
        names: set[str] = set(said.pop("openings", ()))
        said.pop("attributes", None)
        return names | {f"{key} {value}" for key, value in (*said.items(), *self.attributes)}


class SiteKind(Kind, frozen=True):
    """Head of a site."""

    node: Literal["site"]
    turn: int = 0
    """Quarter turns of the frame from east."""
    is_turned: bool = False
    """True if the heading is off these quarter turns; otherwise it has no numbers."""


class StoreyKind(Kind, frozen=True):
    """Head of a storey."""

    node: Literal["storey"]
    is_inset: Flag = msgspec.field(default=0, name="arity")
    is_first: Flag = msgspec.field(default=0, name="rows")
    """1 if the storey states the frame; the storeys above have the same."""


class SplitKind(Kind, frozen=True):
    """Record with a number of children that it states."""

    node: Literal["slice", "cross", "grid", "overlay", "bend", "border"]
    axis: str = ""
    arity: int = 0
    """Parts of a slice, columns, items of an overlay, pieces of a bend, segments of a border."""
    rows: int = 0
    """Rows of a cross or a grid, or lanes of a bend."""
    strip: int = 0
    """Number of the width, from 1, that this has in its parent; 0 if it has a share."""
    side: int = 0
    """Side of its leaf on which a border is."""
    is_even: bool = False
    """True if the share of a part copies the last equal part before it."""


class PinwheelKind(Kind, frozen=True):
    """Four arms about a middle."""

    node: Literal["pinwheel"]
    is_mirrored: Flag = msgspec.field(default=0, name="arity")
    strip: int = 0
    is_even: bool = False


class PlacedKind(Kind, frozen=True):
    """Place of a tree on an overlay, or beside a bend."""

    node: Literal["item", "bank"]
    is_placed: Flag = msgspec.field(default=0, name="arity")


class LeafKind(Kind, frozen=True):
    """Record without children of its partition; a part or a segment is no object."""

    node: Literal["leaf", "lane", "part", "segment"]
    merge: int = 0
    quarter: int = 0
    strip: int = 0
    is_even: bool = False
    is_root: bool = False
    """True if the object has no parent in the scene, though it stands on something."""


class MemberKind(Kind, frozen=True):
    """One of the objects of a unit, in the unit's relation."""

    node: Literal["member"]
    relation: str = ""


class UnitKind(Kind, frozen=True):
    """An object or a group, in its relation to a host."""

    node: Literal["unit"]
    openings: tuple[str, ...] = ()
    """Names from `OPENINGS` that it has."""
    relation: str = ""
    side: int = 0
    """Side of the host."""
    gap: str = ""
    align: str = ""
    slot: int = 0
    turn: int = 0
    """Quarter turns of the heading from the host's side."""
    is_turned: bool = False
    as_last: AsLast = ""
    """Extents that it copies from the last unit with the same `what`."""
    is_group: bool = False
    is_on_top: bool = False
    """True if the height counts from its bearer's top, not from its underside."""
    is_tilted: bool = False
    is_root: bool = False

    def to_relation(self, host: int) -> Relation:
        """Return the relation to a host of some rank."""
        return Relation(
            kind=RelationKind[self.relation],
            host=host,
            side=self.side,
            gap=Gap[self.gap],
            align=Align[self.align],
            slot=self.slot,
            quadrant=self.turn,
        )


KINDS: Mapping[str, type[Kind]] = {"scene": Kind, "width": Kind} | {
    node: each for each in Kind.__subclasses__() for node in get_args(get_type_hints(each)["node"])
}
"""Types of kinds by node."""
OF_RECORD = {n: set(Record.__slots__) & set(each.__struct_fields__) for n, each in KINDS.items()}
"""Fields that kinds share with their records, by node."""


def scene_kind(domain: str, theme: str = "") -> Kind:
    """Return the kind of a program's root; `theme` is empty for a scene without one."""
    return Kind("scene", domain=domain, attributes=(("theme", theme),) if theme else ())


def theme_of(kind: Kind) -> str:
    """Return the theme of a program's root; empty if it has none."""
    return str(dict(kind.attributes).get("theme", ""))


CATEGORY_IDS = {category.name: category.id for category in CATALOGUE.values()}
CATEGORY_IS_COARSE = {c.name: c.level == "coarse" for c in CATALOGUE.values()}


def shaping(obj: SceneObject) -> Attributes:
    """Return the attributes of an object that belong to its kind."""
    return tuple((name, obj.attributes[name]) for name in SHAPING if name in obj.attributes)


def what_of(obj: SceneObject) -> What:
    """Return the key of an object, as `Kind.what` of its kind."""
    return obj.category, obj.domain, shaping(obj)


def openings(obj: SceneObject) -> tuple[str, ...]:
    """Return the names of the openings that an object has."""
    return tuple(name for name in OPENINGS if name in obj.attributes)


def looks(obj: SceneObject) -> dict[str, AttributeValue]:
    """Return the attributes that neither shape an object nor are openings."""
    return {k: v for k, v in obj.attributes.items() if k not in SHAPING and k not in OPENINGS}


def same_part(kind: Kind) -> tuple[str, str]:
    """Return the key of parts that may be equally wide."""
    return kind.node, kind.category


class Word(msgspec.Struct, frozen=True, array_like=True):
    """Word of a leaf: everything about an object but its box, as partitions carry it."""

    category: str
    domain: ObjectDomain
    attributes: Attributes

    @staticmethod
    def from_object(obj: SceneObject) -> str:
        """Write the word of an object as text."""
        return msgspec.json.encode(what_of(obj)).decode()

    @staticmethod
    def read(text: str) -> Word:
        """Read the word from text."""
        return msgspec.json.decode(text, type=Word)
