"""Pattern of a query: its variables, and the relations between them.

object                                    any object
robot pursues goal                        pairs of a robot and its goal
place a connects place b connects goal    variables of one kind need names
strategy falls_back_to+ strategy last     one or more edges; * for zero or more
place a connects(road) place b            an edge with a name, for patterns that use the relation twice
goal, no peer pursues goal                negation
"home" connects place                     a node by its name
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from ...base.errors import Fault, InputError, did_you_mean
from ...expression import FUNCTIONS, blank_texts
from ..declaration import Relation
from ..schema import Schema

# Keywords of the sections of a query, in the order in which they must be written.
SECTIONS = ("where", "order by", "limit", "give", "as of", "changed since")
_SECTION = re.compile(r"(?<![\w.])(where|order\s+by|limit|give|as\s+of|changed\s+since)(?!\w)")


@dataclass(frozen=True)
class Section:
    """Section of a query's text, which begins with a keyword such as `where`, or a part of a section.

    Attributes:
        text: Text of the query up to the end of the section. Everything before the section is blank, so that columns of
            faults are columns of the query.
        start: 0-based offset at which the section starts in `text`.
    """

    text: str
    start: int

    @property
    def content(self) -> str:
        """Text of the section, without surrounding white space."""
        return self.text[self.start :].strip()

    def fault(self, message: str, hint: str = "", at: int | None = None) -> InputError:
        """Create the error for a fault in this section, at an offset in the text (0-based) or at the first word."""
        blank = len(self.text[self.start :]) - len(self.text[self.start :].lstrip())
        return InputError(Fault(message, column=1 + (self.start + blank if at is None else at), hint=hint))

    def split(self) -> list[Section]:
        """Split the section at its commas, except those in brackets and quotes."""
        blanked, depth, begin, parts = blank_texts(self.text), 0, self.start, []
        for at in range(self.start, len(blanked)):
            depth += (blanked[at] in "([") - (blanked[at] in ")]")
            if blanked[at] == "," and depth == 0:
                parts.append(_section(self.text, begin, at))
                begin = at + 1
        return [*parts, _section(self.text, begin, len(self.text))]


def sections_of(text: str) -> dict[str, Section]:
    """Split a query into its sections, by keyword; the pattern has the empty keyword.

    Raises:
        InputError: A section is repeated, out of order, or empty.
    """
    found: dict[str, Section] = {}
    heads = [("", 0, 0), *((" ".join(m[0].split()), m.start(), m.end()) for m in _SECTION.finditer(blank_texts(text)))]
    ends = [start for _, start, _ in heads[1:]] + [len(text)]
    for (word, start, begin), end in zip(heads, ends, strict=True):
        section = _section(text, begin, end)
        if word in found:
            raise section.fault(f"'{word}' is repeated.", "Join the two by 'and', or drop one.", start)
        if any(SECTIONS.index(other) > SECTIONS.index(word) for other in found if other and word):
            raise section.fault(f"'{word}' is out of order.", f"The order is: {', '.join(SECTIONS)}.", start)
        if word and not section.content:
            raise section.fault(f"nothing follows '{word}'.", at=start)
        found[word] = section
    return found


def _section(text: str, start: int, end: int) -> Section:
    return Section(re.sub(r"[^\n]", " ", text[:start]) + text[start:end], start)


_TOKEN = re.compile(r"""\s*([A-Za-z_]\w*|"[^"]*"|'[^']*'|\S)""")
_RESERVED = frozenset({"and", "or", "not", "if", "else", "inf", "True", "False", "no", "now", "ago", "descending"})
MOST = 12
"""Maximum number of variables of a pattern."""


@dataclass(frozen=True)
class Variable:
    """Variable of a query.

    Attributes:
        name: Name in the query, or the name of the kind if the query gives none. For a node in quotes, the quoted text.
        kind: Kind of the nodes, including kinds that extend it; None for a node in quotes.
        node: Name of the node if the query names one in quotes; None for any node of the kind.
        hidden: Whether the variable occurs only in a `no` clause, so that answers do not contain it.
    """

    name: str
    kind: str | None
    node: str | None = None
    hidden: bool = False


@dataclass(frozen=True)
class Link:
    """Relation that a pattern requires between the nodes of two variables.

    Attributes:
        source: Index of the variable at the start of the edge.
        relation: Relation of the edge.
        target: Index of the variable at the end of the edge.
        name: Name of the edge in the query.
        steps: Minimum and maximum number of edges from source to target; (1, 1) for a single edge. No maximum if None.
    """

    source: int
    relation: Relation
    target: int
    name: str
    steps: tuple[int, int | None] = (1, 1)

    @property
    def plain(self) -> bool:
        """Whether the link is a single edge, so that a query can read the attributes of the edge."""
        return self.steps == (1, 1)


AbsentClause = tuple[tuple[int, ...], list[Link]]
"""A `no` clause: indices of the variables that occur only in it, and the links that must not exist together."""


@dataclass
class Pattern:
    """Variables of a query and links between them, in the order of the query's text."""

    variables: list[Variable] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    # `no` clauses; a variable of one of them is not visible in the others.
    absent: list[AbsentClause] = field(default_factory=list)

    @property
    def shown(self) -> list[int]:
        """Indices of the variables that an answer contains."""
        return [i for i, variable in enumerate(self.variables) if not variable.hidden and variable.node is None]


def read_pattern(section: Section, schema: Schema) -> Pattern:
    """Parse the pattern of a query.

    Raises:
        InputError: An unknown kind, relation or name, a relation that does not join these kinds, or invalid syntax.
    """
    pattern = Pattern()
    if not section.content:
        return pattern
    clauses = [_Clause(part, schema, pattern) for part in section.split()]
    # Positive clauses come first: a `no` clause may name a variable that a later clause introduces.
    for clause in sorted(clauses, key=lambda each: each.negative):
        clause.read()
    if len(pattern.variables) > MOST:
        raise section.fault(f"a query has at most {MOST} variables, found {len(pattern.variables)}.")
    if not pattern.shown and not any(variable.node for variable in pattern.variables):
        raise section.fault("a query that has only 'no' clauses has no answer.", "Name first what you look for.")
    return pattern


class _Clause:
    """Reads one clause, such as `no peer pursues goal`, into the pattern."""

    def __init__(self, section: Section, schema: Schema, pattern: Pattern) -> None:
        self._section = section
        self._schema = schema
        self._pattern = pattern
        self._tokens = [(m[1], m.start(1)) for m in _TOKEN.finditer(section.text, section.start)]
        self._at, self._first = 0, 0
        self.negative = bool(self._tokens) and self._tokens[0][0] == "no"

    def read(self) -> None:
        if not self._tokens:
            raise self._section.fault("a clause is empty.", "Drop a comma.")
        self._first = len(self._pattern.variables)
        self._at = int(self.negative)
        links, left = [], self._variable()
        while self._at < len(self._tokens):
            position = self._tokens[self._at][1]
            relation, name, steps = self._relation()
            right = self._variable()
            link = Link(left, relation, right, name, steps)
            self._join(link, position)
            links.append(link)
            left = right
        if not self.negative:
            self._pattern.links += links
        elif not links:
            raise self._section.fault("'no' needs a relation, such as: no peer pursues goal.")
        else:
            self._pattern.absent.append((tuple(range(self._first, len(self._pattern.variables))), links))

    def _variable(self) -> int:
        token, position = self._next("a kind or a name")
        if token[0] in "\"'":
            return self._known(Variable(token, None, token[1:-1], self.negative))
        names = {variable.name: i for i, variable in self._visible()}
        if token in names and not self._named(token):
            return names[token]
        if token not in self._schema.kinds:
            there = [*self._schema.kinds, *names]
            raise self._fault(
                f"'{token}' is neither a kind nor a name of this query.", did_you_mean(token, there), position
            )
        name = token
        if self._named(token):
            name, position = self._next("a name")
            if name in names:
                kind = self._pattern.variables[names[name]].kind
                if kind != token:
                    raise self._fault(f"'{name}' is a {kind or 'node'} already, not a {token}.", at=position)
                return names[name]
        return self._known(Variable(name, token, None, self.negative))

    def _visible(self) -> list[tuple[int, Variable]]:
        """Variables of the positive clauses and of this clause, with their indices."""
        return [(i, v) for i, v in enumerate(self._pattern.variables) if i >= self._first or not v.hidden]

    def _named(self, kind: str) -> bool:
        """Whether the next token is the name of a variable of this kind."""
        if kind not in self._schema.kinds or self._at >= len(self._tokens):
            return False
        token, position = self._tokens[self._at]
        if not re.match(r"[A-Za-z_]", token) or token in self._schema.relations:
            return False
        if token in self._schema.kinds or token in FUNCTIONS or token in _RESERVED:
            hint = did_you_mean(token, self._schema.relations, "The schema")
            raise self._fault(f"'{token}' is not a relation and cannot be a name.", hint, position)
        following = self._tokens[self._at + 1][0] if self._at + 1 < len(self._tokens) else None
        if following is not None and following not in self._schema.relations:
            hint = did_you_mean(token, self._schema.relations, "The schema")
            raise self._fault(f"there is no relation named '{token}'.", hint, position)
        return True

    def _known(self, variable: Variable) -> int:
        """Index of the variable of that name in the pattern; it is added if missing."""
        for i, other in self._visible():
            if other.name == variable.name or (variable.node is not None and other.node == variable.node):
                return i
        self._pattern.variables.append(variable)
        return len(self._pattern.variables) - 1

    def _relation(self) -> tuple[Relation, str, tuple[int, int | None]]:
        token, position = self._next("a relation")
        if token not in self._schema.relations:
            hint = did_you_mean(token, self._schema.relations, "The schema")
            raise self._fault(f"there is no relation named '{token}'.", hint, position)
        relation, following = self._schema.relations[token], self._peek()
        if following in ("+", "*"):
            self._at += 1
            return relation, "", (int(following == "+"), None)
        if following != "(":
            return relation, token, (1, 1)
        self._at += 1
        name, position = self._next("a name")
        taken = {*self._schema.kinds, *self._schema.relations, *FUNCTIONS, *_RESERVED}
        taken |= {variable.name for variable in self._pattern.variables} | {link.name for link in self._pattern.links}
        if not re.match(r"[A-Za-z_]", name) or name in taken:
            raise self._fault(f"'{name}' cannot name an edge: it is in use or not a name.", at=position)
        closing, position = self._next("')'")
        if closing != ")":
            raise self._fault(f"a name of an edge ends with ')', found '{closing}'.", at=position)
        return relation, name, (1, 1)

    def _join(self, link: Link, position: int) -> None:
        """Check that the relation of a link can join the kinds of its two variables."""
        sides = (
            ("starts at", self._pattern.variables[link.source], link.relation.sources),
            ("ends at", self._pattern.variables[link.target], link.relation.targets),
        )
        for end, variable, kinds in sides:
            possible = {kind for each in kinds for kind in self._schema.families[each]}
            if variable.kind is not None and not self._schema.families[variable.kind] & possible:
                raise self._fault(
                    f"'{link.relation.name}' never {end} a {variable.kind}.", f"It {end}: {', '.join(kinds)}.", position
                )

    def _peek(self) -> str | None:
        return self._tokens[self._at][0] if self._at < len(self._tokens) else None

    def _next(self, wanted: str) -> tuple[str, int]:
        if self._at >= len(self._tokens):
            raise self._fault(f"{wanted} is missing at the end.", at=len(self._section.text.rstrip()))
        self._at += 1
        return self._tokens[self._at - 1]

    def _fault(self, message: str, hint: str = "", at: int | None = None) -> InputError:
        return self._section.fault(message, hint, at)
