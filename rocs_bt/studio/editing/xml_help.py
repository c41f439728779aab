"""Completion, descriptions and definitions in missions in XML."""

from __future__ import annotations

import re
from pathlib import Path

from ...base.nesting import descendants
from ...declare import Location
from .elements import NAME, Element, parse
from .help import Description, Item, names_instead
from .vocabulary import KEY, NodeInfo, PortInfo, trees_in, vocabulary

_OPEN_TAG = re.compile(rf"""<({NAME}|)((?:[^<>"']|"[^"]*"|'[^']*')*)$""")
_OPEN_VALUE = re.compile(rf"""<({NAME})((?:[^<>"']|"[^"]*"|'[^']*')*?)({NAME})\s*=\s*(["'])([^"'<]*)$""")
_WORD = re.compile(rf"({NAME}|)$")
_WRITTEN = re.compile(rf"\b({NAME})\s*=")


def complete_xml(path: Path, text: str, at: int, *, code: bool = True) -> list[Item]:
    """Nodes after `<`, ports in a tag, values and keys of the blackboard in quotes."""
    before = text[:at]
    if before.rfind("<!--") > before.rfind("-->"):
        return []
    if value := _OPEN_VALUE.search(before):
        return _values(path, text, at, value, code)
    tag = _OPEN_TAG.search(before)
    if tag is None or tag[1].startswith(("?", "!")):
        return []
    known = vocabulary(path, text, code=code)
    if not tag[2]:
        return _tags(text, at, tag[1], known)
    word = _WORD.search(before)
    start = at - len(word[1]) if word else at
    rest = re.match(r"""[^<>]*""", text[at:])
    given = {*_WRITTEN.findall(tag[2]), *_WRITTEN.findall(rest[0] if rest else "")}
    info = _info(tag[1], tag[2] + (rest[0] if rest else ""), known)
    ports = info.ports if info else ()
    return [
        Item(p.name, "port", _typed(p), p.doc, f'{p.name}="$1"', start, at)
        for p in sorted(ports, key=lambda p: (p.default is not None, p.name[0] == "_"))
        if p.name not in given
    ]


def describe_xml(path: Path, text: str, at: int, *, code: bool = True) -> Description | None:
    """Ports of the node, or the port, at an offset."""
    element = _element(text, at)
    if element is None:
        return None
    info = _info(element.tag, text[element.start : element.inner], vocabulary(path, text, code=code))
    if info is None:
        return None
    attribute = next((a for a in element.attributes if a.at <= at <= a.end), None)
    if attribute is not None:
        port = next((p for p in info.ports if p.name == attribute.name), None)
        if port is None:
            return None
        return Description(f"{info.name}.{port.name}", _typed(port), port.doc, (), attribute.at, attribute.end)
    rows = tuple(f"{p.name}: {_typed(p)}{'. ' + p.doc if p.doc else ''}" for p in info.ports if p.name[0] != "_")
    return Description(info.name, info.kind, info.doc, rows, element.start, element.start + 1 + len(element.tag))


def define_xml(path: Path, text: str, at: int, *, code: bool = True) -> Location | None:
    """Definition of what is at an offset: a tree, a node's class, or the first writer of a key."""
    element = _element(text, at)
    if element is None:
        return None
    attribute = next((a for a in element.attributes if a.at <= at <= a.end), None)
    if attribute and attribute.name != "ID" and (key := KEY.fullmatch(attribute.value)):
        return _writer(path, text, key[1], code)
    info = _info(element.tag, text[element.start : element.inner], vocabulary(path, text, code=code))
    found = info.definition() if info else None
    return None if found is None else Location(found[0], found[1], 1)


def form(path: Path, text: str, at: int, *, code: bool = True) -> tuple[NodeInfo, Element] | None:
    """Node at an offset, for a form: what its class declares, and its element; None where no node is."""
    element = _element(text, at)
    if element is None or element.tag in ("root", "BehaviorTree") or (element.parent and not element.parent.parent):
        return None
    info = _info(element.tag, text[element.start : element.inner], vocabulary(path, text, code=code))
    return info or NodeInfo(element.tag, "unknown"), element


def keys_in(text: str) -> list[str]:
    """Keys of the blackboard in a text, as they are written in ports."""
    return sorted({f"{{{key}}}" for key in KEY.findall(text)})


def _element(text: str, at: int) -> Element | None:
    document = parse(text, tolerant=True)
    element = document.around(at) if document else None
    return element if element is not None and element.tag else None


def _info(tag: str, written: str, known: dict[str, NodeInfo]) -> NodeInfo | None:
    named = re.search(r"""\bID\s*=\s*["']([^"']*)""", written)
    if tag in ("SubTree", "Action", "Condition", "Control", "Decorator") and named:
        return known.get(f"SubTree {named[1]}" if tag == "SubTree" else named[1])
    return known.get(tag)


def _typed(port: PortInfo) -> str:
    default = "required" if port.default is None else f"default {port.default}" if port.default else ""
    return " ".join(filter(None, (port.direction, port.type.removeprefix("std::"), default)))


def _tags(text: str, at: int, typed: str, known: dict[str, NodeInfo]) -> list[Item]:
    start = at - len(typed)
    closed = bool(re.match(rf"({NAME})?[^<>]*/?>", text[at:]))
    items = []
    for info in known.values():
        label = f"SubTree {info.name}" if info.kind == "SubTree" else info.name
        new = info.text[1:]
        if closed:
            new = label if info.kind != "SubTree" else f'SubTree ID="{info.name}"'
        elif info.kind in ("Control", "Decorator"):
            new = f"{new.removesuffix('/>')}>$1</{info.name}>"
        items.append(Item(label, info.kind, info.kind, info.doc, new, start, at))
    return items


def _values(path: Path, text: str, at: int, value: re.Match[str], code: bool) -> list[Item]:
    tag, _, port, quote, typed = value.groups()
    start, found = at - len(typed), list[Item]()
    end = text.find(quote, at)
    end = at if end < 0 or "\n" in text[at:end] or "<" in text[at:end] else end
    if tag == "SubTree" and port == "ID":
        trees = [info for info in vocabulary(path, text, code=code).values() if info.kind == "SubTree"]
        return [Item(info.name, "SubTree", info.doc, "", info.name, start, end) for info in trees]
    if tag == "root":
        return [Item(t.name, "SubTree", t.doc, "", t.name, start, end) for t in trees_in(path, text)]
    brace = typed.rfind("{")
    keys = [key for key in keys_in(text[: at - len(typed)] + text[end:]) if key != "{=}"]
    found += [Item(key, "key", "blackboard", "", key, start, end) for key in keys if brace >= 0 or not typed]
    if brace < 0:
        whole = text[:start] + text[start:end] + ("" if text.startswith(quote, end) else f"{quote}/>") + text[end:]
        names = names_instead(path, whole, start, end, code=code)
        found += [Item(name, "value", "", "", name, start, end) for name in names]
    return found


def _writer(path: Path, text: str, key: str, code: bool) -> Location | None:
    """First node that writes a key: by an output port, or a script."""
    document = parse(text, tolerant=True)
    known = vocabulary(path, text, code=code)
    for element in descendants(document) if document else ():
        info = _info(element.tag, text[element.start : element.inner], known)
        outputs = {port.name for port in info.ports if port.direction != "input"} if info else set()
        for a in element.attributes:
            script = element.tag == "Script" and re.search(rf"\b{re.escape(key)}\s*:?=", a.value)
            if script or (a.name in outputs and a.value == f"{{{key}}}"):
                line = text.count("\n", 0, a.at) + 1
                return Location(path, line, a.at - text.rfind("\n", 0, a.at))
    return None
