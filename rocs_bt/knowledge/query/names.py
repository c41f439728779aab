"""Resolution of the names in a query's expressions, and the code that reads their values.

The generated code reads the query's `Match`: `n` and `r` hold the node name and the row of each variable, `e` the row
of each edge, and `c` is the `Execution`. The code contains only names from a schema, a pattern or Python, never text of
the user.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...base.errors import did_you_mean
from ...base.geometry import Pose2
from ...base.units import ANGLE, LENGTH, NONE, TIME, Dimension
from ...expression import Misuse
from ...expression.environment import SignalLayout
from ..attribute import Attribute, Live
from ..schema import Schema
from .parameter import Parameter
from .pattern import Pattern

_POSE: Mapping[str, Dimension] = {"x": LENGTH, "y": LENGTH, "yaw": ANGLE}
_SORTS = {float: "number", int: "number", bool: "truth", str: "text", tuple: "numbers", Pose2: "pose", Live: "live"}


@dataclass(frozen=True)
class Meaning:
    """Meaning of a name.

    Attributes:
        sort: Type: `number`, `truth`, `text`, `pose`, `path`, `numbers`, `node`, `edge` or `live`.
        code: Source code that computes the value.
        variables: Indices of the variables that the value depends on.
        links: Indices of the links with the edges that the value depends on.
        dimension: Physical dimension of a `number` or of `numbers`.
        size: Number of elements of `numbers`.
        owner: Source code of the name of the node with the attribute; empty if the name is not an attribute of a node.
        attribute: Name of the attribute; empty if the name is not an attribute.
        whole: Whether a `number` is an integer, which may be too large for a float.
    """

    sort: str
    code: str
    variables: frozenset[int] = frozenset()
    links: frozenset[int] = frozenset()
    dimension: Dimension = NONE
    size: int = 0
    owner: str = ""
    attribute: str = ""
    whole: bool = False


@dataclass
class Names:
    """Resolver of the names in one query.

    A name is searched among the parameters, the variables, the edges, the attributes of the first variable, and the
    robot's signals, in that order. `robot` is the querying robot unless a variable has that name; `now` is the time.

    Attributes:
        schema: Schema of the graph.
        pattern: The query's variables and links.
        parameters: Types of the parameters.
        signals: The robot's signals; None if unknown.
        read_signals: Signals that the query reads.
    """

    schema: Schema
    pattern: Pattern
    parameters: Mapping[str, Parameter]
    signals: SignalLayout | None = None
    read_signals: dict[str, None] = field(default_factory=dict)

    def known(self, names: list[str]) -> Meaning | None:
        """Meaning of a dotted name, given as the list of its parts; None for an unknown name.

        Raises:
            Misuse: The name is ambiguous.
        """
        first, *rest = names
        if first in self.parameters:
            return self._component(self._parameter(first), rest)
        for i in self.pattern.shown:
            if self.pattern.variables[i].name == first:
                return self.of_variable(i, rest)
        edges = [j for j, link in enumerate(self.pattern.links) if link.name == first]
        if len(edges) > 1:
            one = ".".join(("one", *rest))
            raise Misuse(f"'{first}' names several edges: name each, as in {first}(one), and write {one}.")
        if edges:
            return self._of_edge(edges[0], rest)
        if self.pattern.shown and (found := self.of_variable(self.pattern.shown[0], names)) is not None:
            return found
        if first == "robot":
            return Meaning("node", "c.me") if not rest else self._component(Meaning("pose", "c.here"), rest[1:])
        if first == "now" and not rest:
            return Meaning("number", "c.t", dimension=TIME)
        return self._signal(first) if not rest else None

    def of_variable(self, i: int, rest: list[str]) -> Meaning | None:
        """Meaning of the attribute `rest` of a variable, or of the variable itself if `rest` is empty."""
        kind, variables = self.pattern.variables[i].kind, frozenset({i})
        if not rest:
            return Meaning("node", f"n[{i}]", variables)
        if kind is None:
            return None
        if rest[0] == "kind" and len(rest) == 1:
            return Meaning("text", f"r[{i}]['kind']", variables)
        found = self._attribute(self.schema.kinds[kind].attributes, f"r[{i}]", rest, variables, frozenset(), f"n[{i}]")
        if found is not None and rest == ["pose"] and "robot" in self.schema.families[kind]:
            code = f"(c.here if n[{i}] == c.me else r[{i}]['pose'])"
            return Meaning("pose", code, variables, owner=found.owner, attribute="pose")
        return found

    def _of_edge(self, j: int, rest: list[str]) -> Meaning | None:
        if not rest:
            return Meaning("edge", f"e[{j}]", links=frozenset({j}))
        declared = self.pattern.links[j].relation.attributes
        return self._attribute(declared, f"e[{j}]", rest, frozenset(), frozenset({j}), "")

    def _attribute(
        self,
        declared: Mapping[str, Attribute],
        row: str,
        rest: list[str],
        variables: frozenset[int],
        links: frozenset[int],
        owner: str,
    ) -> Meaning | None:
        name = rest[0]
        if rest == ["t"]:
            return Meaning("number", f"{row}['t']", variables, links, TIME)
        if rest == ["revision"]:
            return Meaning("number", f"{row}['revision']", variables, links)
        if name not in declared:
            return None
        attribute = declared[name]
        meaning = Meaning(
            _SORTS[attribute.type],
            f"{row}[{name!r}]",
            variables,
            links,
            attribute.dimensions[0],
            attribute.size,
            owner,
            name,
            whole=attribute.type is int,
        )
        return self._component(meaning, rest[1:])

    def _component(self, meaning: Meaning, rest: list[str]) -> Meaning | None:
        """Meaning of a component, such as the `x` of a pose; the given meaning itself if `rest` is empty."""
        if not rest:
            return meaning
        if meaning.sort != "pose" or len(rest) > 1 or rest[0] not in _POSE:
            return None
        code = f"(None if {meaning.code} is None else {meaning.code}.{rest[0]})"
        return Meaning("number", code, meaning.variables, meaning.links, _POSE[rest[0]], 0, meaning.owner, "pose")

    def _parameter(self, name: str) -> Meaning:
        kind = self.parameters[name]
        return Meaning("path" if kind.type is tuple else _SORTS[kind.type], f"c.p[{name!r}]", dimension=kind.dimension)

    def _signal(self, name: str) -> Meaning | None:
        if self.signals is None or name not in self.signals.names:
            return None
        self.read_signals[name] = None
        spec = self.signals.spec(name)
        code = f"c.s[{name!r}]"
        if spec.size == 1:
            return Meaning("number", f"{code}[0]", dimension=spec.dimensions[0])
        if spec.dimension is None:
            raise Misuse(f"the signal '{name}' has {spec.size} values of different units; use `robot` for its pose.")
        return Meaning("numbers", code, dimension=spec.dimension, size=spec.size)

    def unknown(self, names: list[str]) -> str:
        """Error message for an unknown name, with similar known names."""
        if names[-2:] == ["pose", "z"]:
            written = "the signal height" if names[0] == "robot" else ".".join((*names[:-2], "z"))
            return f"a pose has no 'z', which is an attribute of the node; write {written}."
        variables = {self.pattern.variables[i].name: i for i in self.pattern.shown}
        edges = {link.name: link for link in self.pattern.links if link.name}
        if len(names) > 1 and names[0] in variables:
            kind = self.pattern.variables[variables[names[0]]].kind or ""
            return f"a {kind} has no '{names[1]}'. {self._hint(names[1], self.schema.kinds[kind].attributes, kind)}"
        if len(names) > 1 and names[0] in edges:
            return f"'{names[0]}' has no '{names[1]}'. {did_you_mean(names[1], edges[names[0]].relation.attributes)}"
        shown = self.pattern.shown
        own = self.pattern.variables[shown[0]].kind if shown else None
        attributes = self.schema.kinds[own].attributes if own is not None else {}
        signals = self.signals.names if self.signals is not None else ()
        known = {*attributes, *variables, *edges, *self.parameters, *signals, "robot", "now"}
        if own is not None and (elsewhere := self._hint(names[0], attributes, own)).startswith("It is"):
            return f"nothing is named '{'.'.join(names)}' here. {elsewhere}"
        return f"nothing is named '{'.'.join(names)}' here. {did_you_mean(names[0], known, 'The query')}"

    def _hint(self, name: str, attributes: Mapping[str, Attribute], kind: str) -> str:
        """Hint for an unknown attribute: kinds that extend this kind and have the attribute, or else similar names."""
        having = [k for k in self.schema.families[kind] if name in self.schema.kinds[k].attributes]
        if having:
            return f"It is an attribute of: {', '.join(sorted(having))}."
        return did_you_mean(name, attributes, "It")
