"""Kinds of tokens: all that is discrete of a record of a partition, or of a unit, in one symbol.

A unit's kind says what it is and what it is to its host, a record's what it divides and how. What
is discrete beside it are three small numbers of `aeroscene.learning.program.program.Program`: the
rank of the host, the array of a group, and which object of the parent's token bears the token.
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

OPENINGS: tuple[str, ...] = (
    "door_m",
    "door_offset_m",
    "door_height_m",
    "window_m",
    "window_offset_m",
    "window_sill_m",
    "window_height_m",
)
"""Continuous attributes of what has a shell."""
SHAPING = ("form", "is_enterable", "is_start", "rows", "storeys", "use", "zebra_end")
"""Discrete attributes that decide what shape an object has; the others are its looks."""
Attributes = tuple[tuple[str, AttributeValue], ...]
What = tuple[str, str, Attributes]
"""Category, domain and the attributes that shape."""
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
"""Axes of the extents that are those of the last one; what says most comes first."""


class Kind(msgspec.Struct, frozen=True, omit_defaults=True):
    """Tokens that differ in numbers and looks only; scenes and widths have no more than all do."""

    node: str
    """A node of `aeroscene.partition.sequences.record`, or scene, unit or member."""
    category: str = ""
    """Of a unit, a leaf or a lane; of a width what has it first; of a segment what it is."""
    domain: str = ""
    """Of an object indoor or outdoor; of a scene its own."""
    attributes: Attributes = ()
    """Attributes that decide the shape, sorted by name; of a scene its theme."""

    # What is asked of any kind: that of those without such a field.
    strip, turn, relation = 0, 0, ""
    is_turned, is_even, is_root, is_group = False, False, False, False

    @property
    def what(self) -> What:
        """What looks depend on, and what a size is the same as the last one's of."""
        return self.category, self.domain, self.attributes

    @property
    def is_coarse(self) -> bool:
        """Whether the token belongs to the coarse part of a skeleton."""
        return self.node not in {"unit", "member"} or CATEGORY_IS_COARSE.get(self.category, False)

    def traits(self) -> set[str]:
        """What kinds share: a word for each field that is not empty, and for each attribute."""
        said = msgspec.to_builtins(self)
        names: set[str] = set(said.pop("openings", ()))
        said.pop("attributes", None)
        return names | {f"{key} {value}" for key, value in (*said.items(), *self.attributes)}


class SiteKind(Kind, frozen=True):
    """Head of a site."""

    node: Literal["site"]
    turn: int = 0
    """Quarter turns of the frame from east."""
    is_turned: bool = False
    """Whether the heading is off these quarter turns; where it is not it has no numbers."""


class StoreyKind(Kind, frozen=True):
    """Head of a storey."""

    node: Literal["storey"]
    is_inset: Flag = msgspec.field(default=0, name="arity")
    is_first: Flag = msgspec.field(default=0, name="rows")
    """Whether it says where the frame is; the storeys above have the same."""


class SplitKind(Kind, frozen=True):
    """Record with as many others below it as it says."""

    node: Literal["slice", "cross", "grid", "overlay", "bend", "border"]
    axis: str = ""
    arity: int = 0
    """Parts of a slice, columns, items of an overlay, pieces of a bend, segments of a border."""
    rows: int = 0
    """Of a cross or a grid; lanes of a bend."""
    strip: int = 0
    """Number of the width, from 1, that this has in its parent; 0 where it has a share."""
    side: int = 0
    """Side of its leaf that a border is on."""
    is_even: bool = False
    """Whether the share of a part is that of the last part before it that is the same."""


class PinwheelKind(Kind, frozen=True):
    """Four arms about a middle."""

    node: Literal["pinwheel"]
    is_mirrored: Flag = msgspec.field(default=0, name="arity")
    strip: int = 0
    is_even: bool = False


class PlacedKind(Kind, frozen=True):
    """Where a tree is on an overlay, or beside a bend."""

    node: Literal["item", "bank"]
    is_placed: Flag = msgspec.field(default=0, name="arity")


class LeafKind(Kind, frozen=True):
    """Record with nothing of its partition below it; a part or a segment is no object."""

    node: Literal["leaf", "lane", "part", "segment"]
    merge: int = 0
    quarter: int = 0
    strip: int = 0
    is_even: bool = False
    is_root: bool = False
    """Whether the object has no parent in the scene, though it stands on something."""


class MemberKind(Kind, frozen=True):
    """One of the objects of a unit, in the unit's relation."""

    node: Literal["member"]
    relation: str = ""


class UnitKind(Kind, frozen=True):
    """An object, or a group, in its relation to a host."""

    node: Literal["unit"]
    openings: tuple[str, ...] = ()
    """Which of `OPENINGS` it has."""
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
    """Extents that it has of the last one before it that is the same, see `what`."""
    is_group: bool = False
    is_on_top: bool = False
    """Whether the height counts from its bearer's top, not from its underside."""
    is_tilted: bool = False
    is_root: bool = False

    def to_relation(self, host: int) -> Relation:
        """The relation to a host of some rank."""
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
"""Their types by node."""
OF_RECORD = {n: set(Record.__slots__) & set(each.__struct_fields__) for n, each in KINDS.items()}
"""Fields that they have as their records do, by node."""


def scene_kind(domain: str, theme: str = "") -> Kind:
    """The kind of a program's root; its theme is empty where a scene has none."""
    return Kind("scene", domain=domain, attributes=(("theme", theme),) if theme else ())


def theme_of(kind: Kind) -> str:
    """The theme of a program's root, empty where it has none."""
    return str(dict(kind.attributes).get("theme", ""))


CATEGORY_IDS = {category.name: category.id for category in CATALOGUE.values()}
CATEGORY_IS_COARSE = {c.name: c.level == "coarse" for c in CATALOGUE.values()}


def shaping(obj: SceneObject) -> Attributes:
    """The attributes of an object that its kind has."""
    return tuple((name, obj.attributes[name]) for name in SHAPING if name in obj.attributes)


def what_of(obj: SceneObject) -> What:
    """What an object is, as its kind has it."""
    return obj.category, obj.domain, shaping(obj)


def openings(obj: SceneObject) -> tuple[str, ...]:
    """The openings that an object has."""
    return tuple(name for name in OPENINGS if name in obj.attributes)


def looks(obj: SceneObject) -> dict[str, AttributeValue]:
    """The attributes that are neither."""
    return {k: v for k, v in obj.attributes.items() if k not in SHAPING and k not in OPENINGS}


def same_part(kind: Kind) -> tuple[str, str]:
    """What parts have in common that may be equally wide."""
    return kind.node, kind.category


class Word(msgspec.Struct, frozen=True, array_like=True):
    """What a leaf's word says: what an object is beside its box."""

    category: str
    domain: ObjectDomain
    attributes: Attributes

    @staticmethod
    def of(obj: SceneObject) -> str:
        """The word of an object, as text."""
        return msgspec.json.encode(what_of(obj)).decode()

    @staticmethod
    def read(text: str) -> Word:
        """The word that a text is."""
        return msgspec.json.decode(text, type=Word)
