"""Queries built in Python; each is equivalent to a query text.

    find("object").where("moves").within("2 m").nearest(3)
    find("place", "a").link("connects", "place", "b").where("b.tolerance < 0.2 m").give("connects.length")
    find("goal").without("peer pursues goal").as_of("5 s ago")

`str(find)` is the query text, so a query has the same meaning in files, on the command line and in Python.
`knowledge.ask` accepts both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Find:
    """Immutable query builder; each method returns a new one. Made by `find`.

    Attributes:
        first: Name of the first variable.
        pattern: Clauses of the pattern: kinds, variable names and relations between them.
        conditions: Expressions that must all hold.
        order: Sort expression; empty to sort by name.
        most: Maximum number of answers; 0 for all.
        columns: Expressions; each answer contains their values besides the node names.
        moment: Time at which to query the graph; empty for now.
        since: Revision after which an answer must have changed; None for any.
    """

    first: str
    pattern: tuple[str, ...]
    conditions: tuple[str, ...] = ()
    order: str = ""
    most: int = 0
    columns: tuple[str, ...] = ()
    moment: str = ""
    since: int | None = None

    def link(self, relation: str, kind: str, name: str = "") -> Find:
        """Require a relation from the last variable of the pattern to another: `.link("pursues", "goal")`."""
        *others, last = self.pattern
        return replace(self, pattern=(*others, " ".join(filter(None, (last, relation, kind, name)))))

    def also(self, clause: str) -> Find:
        """Require another clause, such as `robot at place`."""
        return replace(self, pattern=(*self.pattern, clause))

    def without(self, clause: str) -> Find:
        """Require that there is no match of a clause such as `peer pursues goal`."""
        return replace(self, pattern=(*self.pattern, f"no {clause}"))

    def where(self, condition: str) -> Find:
        """Require that an expression holds, such as `b.tolerance < 0.2 m`."""
        return replace(self, conditions=(*self.conditions, condition))

    def within(self, reach: str, of: str = "robot") -> Find:
        """Require that the first variable is nearer than `reach`, such as `2 m`, to a variable or a parameter."""
        return self.where(f"distance({self.first}, {of}) < {reach}")

    def nearest(self, count: int = 1, to: str = "robot") -> Find:
        """Keep only the `count` answers nearest to a variable or a parameter, nearest first."""
        return self.order_by(f"distance({self.first}, {to})").limit(count)

    def order_by(self, measure: str, descending: bool = False) -> Find:
        """Sort the answers by the value of an expression, ascending unless `descending`."""
        return replace(self, order=f"{measure} descending" if descending else measure)

    def limit(self, count: int) -> Find:
        """Limit the number of answers."""
        return replace(self, most=count)

    def give(self, *columns: str) -> Find:
        """Add columns to the answers: the values of expressions, such as `connects.length`."""
        return replace(self, columns=(*self.columns, *columns))

    def as_of(self, moment: str) -> Find:
        """Query the graph at an earlier time, such as `12.5 s` or `5 s ago`."""
        return replace(self, moment=moment)

    def changed_since(self, revision: int) -> Find:
        """Keep only answers that have changed after a revision."""
        return replace(self, since=revision)

    def __str__(self) -> str:
        loose = {"or", "if", "implies"}  # operators with a lower precedence than `and`
        several = len(self.conditions) > 1
        conditions = [f"({c})" if several and loose & {*c.split()} else c for c in self.conditions]
        parts = (
            ("", ", ".join(self.pattern)),
            ("where ", " and ".join(conditions)),
            ("order by ", self.order),
            ("limit ", str(self.most or "")),
            ("give ", ", ".join(self.columns)),
            ("as of ", self.moment),
            ("changed since ", "" if self.since is None else str(self.since)),
        )
        return " ".join(word + value for word, value in parts if value)


def find(kind: str, name: str = "") -> Find:
    """Begin a query for nodes of a kind; `name` is the name of the variable, by default the kind."""
    return Find(name or kind, (f"{kind} {name}".strip(),))
