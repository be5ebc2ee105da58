"""OpenStreetMap's XML, read element by element by expat of the standard library.

No other library is needed, so that a map opens after a plain installation. A document type is
refused at its first byte: OpenStreetMap's files have none, and entities that multiply need one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NoReturn
from xml.parsers import expat

from aeroscene.maps.bounds import Bounds, is_rectangle
from aeroscene.maps.document import MapError
from aeroscene.maps.osm_data import OsmData, Relation, Way
from aeroscene.scene import SceneError
from aeroscene.scene.errors import shown

_DEEPEST = 8
_WHOLE = re.compile(r"-?[0-9]{1,19}")
"""A number as OpenStreetMap writes it; int() would also accept blanks and other scripts."""
_Attributes = dict[str, str]


def read_osm_xml(pieces: Iterator[bytes], where: str) -> OsmData:
    """Read the elements of an OSM XML file.

    Args:
        pieces: Bytes of the file, unpacked.
        where: Name of the file in errors.

    Raises:
        MapError: If the file breaks a rule; it names file, line, element and field.
    """
    reader = _Reader()
    try:
        # False: more pieces follow.
        for piece in pieces:
            reader.parser.Parse(piece, False)
        reader.parser.Parse(b"", True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise MapError(
            f"{where} line {error.lineno}: XML is malformed or cut short ({reason}); valid: a "
            "whole OSM XML file"
        ) from None
    except SceneError as error:
        line = reader.parser.CurrentLineNumber
        raise MapError(f"{where} line {line}: {error}") from None
    return reader.data


class _Reader:
    """Receiver of expat's events, which fills an `OsmData`."""

    def __init__(self) -> None:
        self.data = OsmData()
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._refuse_doctype
        self._depth = 0
        self._where = ""
        self._tags: dict[str, str] | None = None
        self._owner: Way | Relation | None = None
        self._handlers: dict[str, Callable[[_Attributes], None]] = {
            "bounds": self._bounds,
            "node": self._node,
            "way": self._way,
            "relation": self._relation,
            "tag": self._tag,
            "nd": self._nd,
            "member": self._member,
        }

    def _refuse_doctype(self, *_: object) -> NoReturn:
        raise MapError("it has a document type; valid: OSM XML, which has none")

    def _start(self, name: str, attributes: _Attributes) -> None:
        # The depth bounds memory: expat keeps all open elements.
        self._depth += 1
        if self._depth == 1 and name != "osm":
            raise MapError(f"its root is {shown(name)}; valid: 'osm'")
        if self._depth > _DEEPEST:
            raise MapError(f"elements are nested deeper than {_DEEPEST}; valid: OSM XML")
        if self._depth > 1 and (handler := self._handlers.get(name)) is not None:
            handler(attributes)

    def _end(self, name: str) -> None:
        self._depth -= 1
        if name in {"node", "way", "relation"}:
            self._owner = self._tags = None

    def _bounds(self, attributes: _Attributes) -> None:
        names = ("minlon", "minlat", "maxlon", "maxlat")
        self._where = "bounds"
        found = Bounds(*(self._number(attributes, name) for name in names))
        if not is_rectangle(found):
            raise MapError(f"bounds are {found}; valid: a rectangle on the globe")
        self.data.bounds = found

    def _node(self, attributes: _Attributes) -> None:
        number = self._id(attributes, "node")
        # Editors keep deleted elements in their files, marked like this.
        if attributes.get("visible") == "false" or attributes.get("action") == "delete":
            return
        place = (self._number(attributes, "lon"), self._number(attributes, "lat"))
        self.data.add_node(number, *place)
        self._tags = {}

    def _way(self, attributes: _Attributes) -> None:
        number = self._id(attributes, "way")
        if attributes.get("visible") != "false" and attributes.get("action") != "delete":
            self._owner = way = Way()
            self._tags, self.data.ways[number] = way.tags, way

    def _relation(self, attributes: _Attributes) -> None:
        number = self._id(attributes, "relation")
        if attributes.get("visible") != "false" and attributes.get("action") != "delete":
            self._owner = relation = Relation()
            self._tags, self.data.relations[number] = relation.tags, relation

    def _tag(self, attributes: _Attributes) -> None:
        if self._tags is None:
            return
        self.data.add_tag(self._tags, attributes.get("k", ""), attributes.get("v", ""), self._where)
        # Nodes are kept as coordinates alone, so tags of a node go to a dictionary of their own.
        if self._owner is None:
            self.data.node_tags[self._number_of_node] = self._tags

    def _nd(self, attributes: _Attributes) -> None:
        if isinstance(self._owner, Way):
            self.data.add_reference(self._owner, self._ref(attributes), self._where)

    def _member(self, attributes: _Attributes) -> None:
        if isinstance(self._owner, Relation):
            kind, role = attributes.get("type", ""), attributes.get("role", "")
            member = (kind, self._ref(attributes), role)
            self.data.add_reference(self._owner, member, self._where)

    def _id(self, attributes: _Attributes, kind: str) -> int:
        # Attributes of a new element end the previous one, even if that was left out.
        self._owner = self._tags = None
        self._where = kind
        number = self._integer(attributes, "id")
        self._where = f"{kind} {number}"
        self._number_of_node = number
        return number

    def _ref(self, attributes: _Attributes) -> int:
        return self._integer(attributes, "ref")

    def _integer(self, attributes: _Attributes, name: str) -> int:
        text = attributes.get(name, "")
        if _WHOLE.fullmatch(text) is None:
            raise MapError(f"{self._where}: {name} is {shown(text)}; valid: a whole number")
        return int(text)

    def _number(self, attributes: _Attributes, name: str) -> float:
        text = attributes.get(name, "")
        try:
            return float(text)
        except ValueError:
            raise MapError(
                f"{self._where}: {name} is {shown(text)}; valid: a number of degrees"
            ) from None
