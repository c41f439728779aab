"""Extension of the expression language to queries: names of the graph, and functions such as `distance`.

An expression is evaluated on a list of floats, like a guard on a snapshot of signals. Each value that it reads has a
position in this list. A *slot* describes how to compute the float at one position.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field

from ...base.errors import did_you_mean
from ...base.units import ANGLE, LENGTH, TIME
from ...expression import FUNCTIONS, TRUTH, Environment, Kind, Misuse, Node
from .names import Meaning, Names

FORMS = {
    "distance": "distance(a) or distance(a, b): distance of a from b, or from the robot [m]; b may be a path",
    "bearing": "bearing(a) or bearing(a, b): bearing of a as seen from b, or from the robot [rad]",
    "age": "age(a): time since a node, an edge or an attribute was written [s]",
    "known": "known(a): whether an attribute is known",
}
"""Functions of queries, in addition to those of the expression language."""


@dataclass(frozen=True)
class Slot:
    """Value that a query's expressions read.

    Attributes:
        code: Source code that computes the value as a float; NaN if unknown.
        variables: Indices of the variables that the value depends on.
        links: Indices of the links with the edges that the value depends on.
        near: If the value is the distance between a variable and a position that no variable changes: index of the
            variable, and source code of the position. Else None.
        same: If the value tells whether a variable is the node of a name that no variable changes: index of the
            variable, and source code of the name. Else None.
    """

    code: str
    variables: frozenset[int]
    links: frozenset[int]
    near: tuple[int, str] | None = None
    same: tuple[int, str] | None = None


@dataclass
class ExpressionScope:
    """Translator of a query's expressions; it collects the slots that they need.

    Attributes:
        text: Query text.
        names: Resolver of names.
        slots: Slots needed so far.
        texts: Quoted texts of the query so far; generated code reads them as `c.k`.
    """

    text: str
    names: Names
    slots: list[Slot] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    @property
    def environment(self) -> Environment:
        """Environment in which `parse` reads the query's expressions."""
        return Environment({}, {}, forms=self)

    # -- the forms of the language ------------------------------------------------------------------------------------

    def read(self, tree: ast.expr, at: Callable[[ast.expr], int]) -> Node | None:
        """Translate a part of an expression that has a special meaning in queries; None for all others. See `Forms`."""
        match tree:
            case ast.Name(id=name) if name in FUNCTIONS or name == "inf":
                return None
            case ast.Name() | ast.Attribute():
                return self._value(self.meaning(tree, at))
            case ast.Subscript():
                return self._part(tree, at)
            case ast.Compare() if any(self._is_text(side, at) for side in (tree.left, *tree.comparators)):
                return self._same(tree, at)
            case ast.Call(func=ast.Name(id=name)) if name not in FUNCTIONS:
                return self._form(name, tree, at)
            case ast.Constant(value=str()):
                raise Misuse("a text is not a number; compare it: mode == 'dock'.")
        return None

    def meaning(self, tree: ast.expr, at: Callable[[ast.expr], int]) -> Meaning:
        """Meaning of a name, a dotted name or a quoted text.

        Raises:
            Misuse: It is none of these, or the name is unknown or ambiguous.
        """
        if isinstance(tree, ast.Constant) and isinstance(tree.value, str):
            start = at(tree)
            return Meaning("text", self._constant(self.text[start + 1 : start + len(tree.value) + 1]))
        names = _dotted(tree)
        if not names:
            raise Misuse("a name is needed here, such as pose or goal.pose.")
        found = self.names.known(names)
        if found is None:
            raise Misuse(self.names.unknown(names))
        return found

    # -- slots --------------------------------------------------------------------------------------------------------

    def _slot(
        self,
        code: str,
        kind: Kind,
        meanings: tuple[Meaning, ...],
        near: tuple[int, str] | None = None,
        same: tuple[int, str] | None = None,
    ) -> Node:
        """Expression node that reads one slot, which is added if it is new."""
        variables = frozenset[int]().union(*(m.variables for m in meanings))
        links = frozenset[int]().union(*(m.links for m in meanings))
        slot = Slot(code, variables, links, near, same)
        if slot not in self.slots:
            self.slots.append(slot)
        at = self.slots.index(slot)
        if kind.boolean:
            read, zero = Node("read", Kind(), start=at, stop=at + 1), Node("number", Kind(), value=0.0)
            return Node("compare", TRUTH, (read, zero), signs=("!=",))
        return Node("read", kind, start=at, stop=at + 1)

    def _value(self, meaning: Meaning) -> Node:
        match meaning.sort:
            case "number":
                return self._slot(_number(meaning), Kind(meaning.dimension), (meaning,))
            case "truth":
                return self._slot(_number(meaning), TRUTH, (meaning,))
            case "numbers":
                return self._group(meaning, range(_sized(meaning)))
        raise Misuse(f"it is {_WORDS[meaning.sort]}, not a number; {_HINTS[meaning.sort]}")

    def _group(self, meaning: Meaning, indices: range) -> Node:
        """Expression node that reads several elements of a list of numbers, one slot for each."""
        codes = [f"number({meaning.code}[{i}] if {meaning.code} is not None else None)" for i in indices]
        start = len(self.slots)
        self.slots += [Slot(code, meaning.variables, meaning.links) for code in codes]
        return Node("read", Kind(meaning.dimension, len(codes)), start=start, stop=start + len(codes))

    def _part(self, tree: ast.Subscript, at: Callable[[ast.expr], int]) -> Node | None:
        if not _dotted(tree.value):
            return None
        meaning = self.meaning(tree.value, at)
        if meaning.sort != "numbers":
            raise Misuse(f"only a list of numbers has an index; '{'.'.join(_dotted(tree.value))}' is not one.")
        indices = range(_sized(meaning))
        if isinstance(tree.slice, ast.Slice):
            if tree.slice.step is not None:
                raise Misuse("a slice has no step.")
            part = indices[_whole(tree.slice.lower) : _whole(tree.slice.upper)]
            if not part:
                raise Misuse(f"it is empty: there are {len(indices)} values.")
            return self._group(meaning, part)
        at_index = _whole(tree.slice)
        if at_index is None or not -len(indices) <= at_index < len(indices):
            raise Misuse(f"it has {len(indices)} values, counted from 0.")
        return _single(self._group(meaning, indices[at_index : at_index + 1 or None]))

    def _is_text(self, tree: ast.expr, at: Callable[[ast.expr], int]) -> bool:
        if isinstance(tree, ast.Constant):
            return isinstance(tree.value, str)
        names = _dotted(tree)
        found = self.names.known(names) if names and names[0] not in FUNCTIONS else None
        return found is not None and found.sort in ("text", "node")

    def _same(self, tree: ast.Compare, at: Callable[[ast.expr], int]) -> Node:
        if len(tree.ops) != 1 or not isinstance(tree.ops[0], (ast.Eq, ast.NotEq)):
            raise Misuse("texts and nodes are compared only by == and !=.")
        sides = tuple(self.meaning(side, at) for side in (tree.left, tree.comparators[0]))
        for side in sides:
            if side.sort not in ("text", "node"):
                raise Misuse(f"a text or a node cannot be compared with {_WORDS[side.sort]}.")
        pin = None
        for one, other in (sides, sides[::-1]):
            if one.sort == "node" and one.variables and not other.variables and not other.links:
                pin = min(one.variables), other.code
        same = self._slot(f"equal({sides[0].code}, {sides[1].code})", TRUTH, sides, same=pin)
        return same if isinstance(tree.ops[0], ast.Eq) else Node("not", TRUTH, (same,))

    def _form(self, name: str, tree: ast.Call, at: Callable[[ast.expr], int]) -> Node:
        if name not in FORMS:
            raise Misuse(f"no function is named '{name}'. {did_you_mean(name, [*FORMS, *FUNCTIONS], 'The language')}")
        most = 2 if name in ("distance", "bearing") else 1
        if tree.keywords or not 1 <= len(tree.args) <= most:
            raise Misuse(f"write {FORMS[name]}.")
        if name in ("distance", "bearing"):
            others = tree.args[1:]
            places = [self._place(self.meaning(arg, at)) for arg in tree.args]
            return self._between(name, places[0], places[1] if others else Meaning("pose", "c.here"))
        meaning = self.meaning(tree.args[0], at)
        if name == "known":
            if not meaning.attribute:
                raise Misuse(f"it needs an attribute. Write {FORMS[name]}.")
            return self._slot(f"float({meaning.code} is not None)", TRUTH, (meaning,))
        return self._age(meaning)

    def _age(self, meaning: Meaning) -> Node:
        if meaning.owner:
            code = f"c.age({meaning.owner}, {meaning.attribute!r})"
        elif meaning.sort == "node":
            code = f"c.age({meaning.code}, None)"
        elif meaning.links:
            code = f"(c.t - e[{min(meaning.links)}]['t'])"
        else:
            raise Misuse(f"only nodes, edges and attributes have an age. Write {FORMS['age']}.")
        return self._slot(code, Kind(TIME), (meaning,))

    def _place(self, meaning: Meaning) -> Meaning:
        """Meaning of an argument of `distance` or `bearing` as a pose or path; a node means its pose."""
        if meaning.sort in ("pose", "path"):
            return meaning
        if meaning.sort == "text":  # in quotes, or a parameter: the name of a node
            return Meaning("pose", f"c.where({meaning.code})", meaning.variables, meaning.links)
        if meaning.sort == "node" and not meaning.variables:
            return Meaning("pose", "c.here")
        if meaning.sort == "node":
            (i,) = meaning.variables
            found = self.names.of_variable(i, ["pose"])
            if found is not None and found.sort == "pose":
                return found
            raise Misuse(f"a {self.names.pattern.variables[i].kind} has no pose.")
        raise Misuse(f"a pose, path or node is needed; this is {_WORDS[meaning.sort]}.")

    def _between(self, name: str, a: Meaning, b: Meaning) -> Node:
        if name == "bearing" or a.sort == b.sort == "path":
            if "path" in (a.sort, b.sort):
                raise Misuse(f"a path has no single position. Write {FORMS[name]}.")
            return self._slot(f"direction({a.code}, {b.code})", Kind(ANGLE), (a, b))
        near = None
        for one, other in ((a, b), (b, a)):
            if one.variables and one.attribute == "pose" and not other.variables and not other.links:
                near = min(one.variables), other.code
        return self._slot(f"apart({a.code}, {b.code})", Kind(LENGTH), (a, b), near)

    def _constant(self, text: str) -> str:
        if text not in self.texts:
            self.texts.append(text)
        return f"c.k[{self.texts.index(text)}]"


def _number(meaning: Meaning) -> str:
    """Source code that reads a value as a float; NaN if unknown."""
    if meaning.whole:
        return f"number({meaning.code})"
    return f"(nan if (v := {meaning.code}) is None else v)"


def _single(node: Node) -> Node:
    """Convert an expression node for a list of one number to one for that number."""
    return Node("read", Kind(node.kind.dimension), start=node.start, stop=node.stop)


def _sized(meaning: Meaning) -> int:
    if not meaning.size:
        raise Misuse("its number of elements is not declared; only lists of a fixed size can be used.")
    return meaning.size


def _whole(tree: ast.expr | None) -> int | None:
    sign, inner = (-1, tree.operand) if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub) else (1, tree)
    if inner is None:
        return None
    if isinstance(inner, ast.Constant) and type(inner.value) is int:
        return sign * inner.value
    raise Misuse("an index is a whole number.")


def _dotted(tree: ast.expr) -> list[str]:
    """The parts of `a.b.c`; empty for anything else."""
    if isinstance(tree, ast.Name):
        return [tree.id]
    if isinstance(tree, ast.Attribute):
        before = _dotted(tree.value)
        return [*before, tree.attr] if before else []
    return []


_WORDS = {
    "number": "a number",
    "truth": "true or false",
    "text": "a text",
    "pose": "a pose",
    "path": "a path",
    "numbers": "a list of numbers",
    "node": "a node",
    "edge": "an edge",
    "live": "the live view of a signal",
}
_HINTS = {
    "text": "compare it: mode == 'dock'.",
    "pose": "write pose.x, pose.y, pose.yaw, or distance(pose, robot).",
    "path": "write distance(pose, path).",
    "node": "write one of its attributes, as in goal.tolerance, or compare it with another.",
    "edge": "write one of its attributes, as in connects.length.",
    "live": "write the name of the signal itself.",
}
