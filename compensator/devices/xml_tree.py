"""XML as a tree whose elements know their line; names without their namespace."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from xml.sax import parseString
from xml.sax.handler import ContentHandler
from xml.sax.xmlreader import AttributesImpl, Locator


@dataclass(frozen=True, eq=False)
class Element:
    """An element of an XML file.

    Attributes:
        tag: its name, without a namespace. line: where it begins, counted from 1.
        pieces: of the text in it, without that of its children.
    """

    tag: str
    attributes: Mapping[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The text in it."""
        return "".join(self.pieces)

    def child(self, tag: str) -> Element | None:
        """The first child of a name."""
        return next((e for e in self.children if e.tag == tag), None)

    def words(self, tag: str) -> str:
        """Text of the first child of a name, stripped; empty where there is none."""
        found = self.child(tag)
        return "" if found is None else found.text.strip()

    def walk(self) -> Iterator[Element]:
        """It and all below it, in the order of the file."""
        left = [self]
        while left:
            here = left.pop()
            yield here
            left += reversed(here.children)

    def find_all(self, tag: str) -> Iterator[Element]:
        """All elements of a name, in the order of the file."""
        return (e for e in self.walk() if e.tag == tag)


def parsed(text: str) -> Element:
    """The document element of a text.

    Raises:
        xml.sax.SAXParseException: it is no complete XML.
    """
    builder = _Builder()
    parseString(text, builder)  # of text: what it declares as its encoding is done with
    return builder.holder.children[0]


class _Builder(ContentHandler):
    """Puts elements below each other as the parser meets them."""

    def __init__(self) -> None:
        super().__init__()
        self.holder = Element("", {}, 0)
        self._stack = [self.holder]
        self._locator: Locator | None = None

    def setDocumentLocator(self, locator: Locator) -> None:
        self._locator = locator

    def startElement(self, name: str, attrs: AttributesImpl) -> None:
        line = self._locator.getLineNumber() if self._locator else None
        made = Element(name.rpartition(":")[2], dict(attrs.items()), line or 0)
        self._stack[-1].children.append(made)
        self._stack.append(made)

    def endElement(self, name: str) -> None:
        self._stack.pop()

    def characters(self, content: str) -> None:
        self._stack[-1].pieces.append(content)
