"""XML scanner that keeps positions, accepts what BehaviorTree.CPP accepts, and is safe for untrusted input.

Document types and entity declarations are rejected, so that no document can grow by expansion or refer to another
file. For valid XML the result is the same as with expat. Unescaped `<` and `&` in attributes, which tinyxml2 accepts,
are accepted with a warning.
"""

from __future__ import annotations

import re

from ...base.errors import Fault, InputError
from .element import ATTRIBUTE, NAME, Element, Source, unescape

MAX_TEXT = 16_000_000
"""Maximum length of a document [characters]."""

MAX_VALUE = 65_536
"""Maximum length of an attribute's value [characters]."""

MAX_ATTRIBUTES = 256
"""Maximum number of attributes of an element."""

MAX_ELEMENTS = 100_000
"""Maximum number of elements of a document."""

MAX_DEPTH = 256
"""Maximum nesting of elements; BehaviorTree.CPP's own limit."""

_PAIR = rf"""{NAME}[ \t\r\n]*=[ \t\r\n]*(?:"[^"<]*"|'[^'<]*')"""
_TAG = re.compile(rf"[ \t\r\n]*<({NAME})((?:[ \t\r\n]+{_PAIR})*)[ \t\r\n]*(/?)>")
_PAIRS = re.compile(rf"""({NAME})[ \t\r\n]*=[ \t\r\n]*(?:"([^"]*)"|'([^']*)')""")
_DOUBLE = re.compile(rf"""({NAME})[ \t\r\n]*=[ \t\r\n]*"([^"]*)\"""")
_OPEN = re.compile(rf"<({NAME})")
_CLOSE = re.compile(rf"</({NAME})[ \t\r\n]*>")
_END = re.compile(r"[ \t\r\n]*(/?)>")
_SPACE = re.compile(r"[ \t\r\n]*")
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
_RAW = re.compile(r"<|&(?!(?:lt|gt|amp|quot|apos|#[0-9]+|#x[0-9a-fA-F]+);)")


def scan(source: Source) -> tuple[Element, list[Fault]]:
    """Scan a document; returns its root element and warnings.

    Raises:
        InputError: The text is not XML, or exceeds a limit.
    """
    return _Scanner(source).document()


class _Scanner:
    def __init__(self, source: Source) -> None:
        self.source = source
        self.text = source.text
        self.at = 0
        self.root: Element | None = None
        self.open: list[Element] = []
        self.texts: list[list[str]] = []
        self.comments: list[str] = []
        self.warnings: list[Fault] = []
        self.count = 0

    def document(self) -> tuple[Element, list[Fault]]:
        if len(self.text) > MAX_TEXT:
            raise self.refused(0, f"the document has {len(self.text)} characters; the maximum is {MAX_TEXT}.")
        if bad := _FORBIDDEN.search(self.text):
            raise self.refused(bad.start(), f"the character U+{ord(bad[0]):04X} is not allowed in XML.")
        self.at = 1 if self.text.startswith("\ufeff") else 0
        while self.at < len(self.text):
            self.tags()
            if self.at < len(self.text):
                self.step()
        if self.open:
            element = self.open[-1]
            raise self.refused(element.at, f"<{element.tag}> is not closed.", f"Write </{element.tag}> at its end.")
        if self.root is None:
            raise self.refused(self.at, "the document has no element.", "Begin with <root BTCPP_format='4'>.")
        return self.root, self.warnings

    def tags(self) -> None:
        """Read consecutive opening tags that are well-formed, which nearly all are; `step` handles all other input."""
        text, source, match = self.text, self.source, _TAG.match
        while (found := match(text, self.at)) is not None and (self.open or self.root is None):
            tag, inside, slash = found.groups()
            attributes: dict[str, str] = {}
            if inside:
                pairs = _DOUBLE.findall(inside) if "'" not in inside else _pairs(inside)
                attributes = dict(pairs)
                if len(attributes) != len(pairs) or len(pairs) > MAX_ATTRIBUTES or len(inside) > MAX_VALUE:
                    return
                if "\r" in inside or ("&" in inside and _RAW.search(inside)):
                    return
                if "&" in inside:
                    for name, value in attributes.items():
                        attributes[name] = unescape(value)
            at = found.start(1) - 1
            if at > self.at and self.texts and self.texts[-1]:
                self.texts[-1].append(text[self.at : at])  # spaces between words are significant
            element = Element(tag, source, at, attributes)
            self.at = found.end()
            self.add(element, bool(slash))

    def add(self, element: Element, closed: bool) -> None:
        """Append an element to the innermost open element."""
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise self.refused(element.at, f"the document has more than {MAX_ELEMENTS} elements.")
        if self.comments:
            element.comments, self.comments = tuple(self.comments), []
        if self.root is None:
            self.root = element
        else:
            self.open[-1].children.append(element)
        if not closed:
            element.children = []
            self.open.append(element)
            self.texts.append([])
            if len(self.open) > MAX_DEPTH:
                raise self.refused(element.at, f"elements are nested more than {MAX_DEPTH} deep.", "Use subtrees.")

    def step(self) -> None:
        """Read the next item: text, a tag or a comment."""
        text, at = self.text, self.at
        if text[at] != "<":
            self.characters()
        elif text.startswith("<!--", at):
            end = self.until("-->", at + 4, "the comment")
            self.comments.append(text[at + 4 : end])
            self.at = end + 3
        elif text.startswith("<![CDATA[", at) and self.open:
            end = self.until("]]>", at + 9, "the CDATA section")
            self.texts[-1].append(text[at + 9 : end])
            self.at = end + 3
        elif text.startswith("<?", at):
            self.at = self.until("?>", at + 2, "the processing instruction") + 2
        elif text.startswith("<!", at):
            hint = "Remove it: document types and entity declarations are not supported."
            raise self.refused(at, "a document type or an entity is declared.", hint)
        elif text.startswith("</", at):
            self.close()
        else:
            self.element()

    def characters(self) -> None:
        end = self.text.find("<", self.at)
        end = len(self.text) if end < 0 else end
        piece = self.text[self.at : end]
        if self.open:
            if self.texts[-1] or not piece.isspace():
                self.texts[-1].append(unescape(piece))
        elif piece.strip(" \t\r\n"):
            space = _SPACE.match(self.text, self.at)
            at = space.end() if space else self.at
            if self.root is not None or "<" not in self.text[end:]:
                raise self.refused(at, "there is text outside of the root element.")
            hint = "Write <!-- ... -->: BehaviorTree.CPP skips it, other tools reject the file."
            self.warnings.append(self.source.fault(at, "there is text before the root element.", hint, warning=True))
        self.at = end

    def element(self) -> None:
        start = self.at
        found = _OPEN.match(self.text, start)
        if found is None:
            raise self.refused(start, "'<' does not begin a tag.", "Write &lt; for a '<' in text.")
        if self.root is not None and not self.open:
            raise self.refused(start, f"<{found[1]}> is a second root.", "Put everything into one <root>.")
        element = Element(found[1], self.source, start)
        self.at = found.end()
        while (end := _END.match(self.text, self.at)) is None:
            self.attribute(element)
        self.at = end.end()
        self.add(element, bool(end[1]))

    def attribute(self, element: Element) -> None:
        found = ATTRIBUTE.match(self.text, self.at)
        if found is None:
            raise self.no_attribute(element)
        name, begin = found[1], found.end()
        end = self.text.find(found[2], begin)
        if end < 0:
            raise self.refused(begin - 1, f"the value of '{name}' has no closing {found[2]}.")
        if end - begin > MAX_VALUE:
            message = f"the value of '{name}' has {end - begin} characters; the maximum is {MAX_VALUE}."
            raise self.refused(begin, message)
        if name in element.attributes:
            raise self.refused(found.start(1), f"<{element.tag}> has '{name}' twice.")
        if len(element.attributes) >= MAX_ATTRIBUTES:
            raise self.refused(found.start(1), f"<{element.tag}> has more than {MAX_ATTRIBUTES} attributes.")
        raw = self.text[begin:end]
        if "<" in raw or "&" in raw:
            self.check_raw(name, raw, begin)
        element.attributes[name] = unescape(raw.replace("\r\n", "\n"))
        self.at = end + 1

    def check_raw(self, name: str, raw: str, begin: int) -> None:
        """Add a warning about an unescaped `<` or `&`, which XML forbids and BehaviorTree.CPP accepts."""
        bad = _RAW.search(raw)
        if bad is None:
            return
        wanted = "&lt;" if bad[0] == "<" else "&amp;"
        message = f"'{bad[0]}' in the value of '{name}' is not well-formed XML."
        place = self.source.position(begin + bad.start())
        hint = f"Write {wanted}: BehaviorTree.CPP accepts it, other tools do not."
        self.warnings.append(Fault(message, self.source.file, *place, hint=hint, warning=True))

    def no_attribute(self, element: Element) -> InputError:
        """Error for a text that is not an attribute, or for a missing closing quote before this text."""
        name = next(reversed(element.attributes), "")
        if "<" in element.attributes.get(name, "") and element.attributes[name].endswith("="):
            message = f"the value of '{name}' extends over other elements: its closing quote is missing."
            return self.refused(element.attribute_positions[name].value - 1, message)
        space = _SPACE.match(self.text, self.at)
        at = space.end() if space else self.at
        return self.refused(at, f"expected an attribute in <{element.tag}>.", 'Write name="value".')

    def close(self) -> None:
        found = _CLOSE.match(self.text, self.at)
        if found is None:
            raise self.refused(self.at, "'</' does not begin a closing tag.", "Write </Name>.")
        if not self.open:
            raise self.refused(self.at, f"</{found[1]}> has no opening tag.")
        element = self.open.pop()
        if element.tag != found[1]:
            line, _ = self.source.position(element.at)
            message = f"expected </{element.tag}> for the tag of line {line}, found </{found[1]}>."
            raise self.refused(self.at, message, "Write the same name in both tags.")
        element.text = "".join(self.texts.pop()).strip()
        self.comments.clear()
        self.at = found.end()

    def until(self, end: str, start: int, what: str) -> int:
        at = self.text.find(end, start)
        if at < 0:
            raise self.refused(self.at, f"{what} is not closed.", f"Close it with {end}")
        return at

    def refused(self, at: int, message: str, hint: str = "") -> InputError:
        return InputError(self.source.fault(at, f"not readable as XML: {message}", hint))


def _pairs(attributes: str) -> list[tuple[str, str]]:
    """Names and values of attributes, of which some are in double and some in single quotes."""
    return [(name, double or single) for name, double, single in _PAIRS.findall(attributes)]
