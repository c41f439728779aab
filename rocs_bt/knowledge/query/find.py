"""Find: queries put together in Python; each is the text that one would write.

    find("object").where("moves").within("2 m").nearest(3)
    find("place", "a").link("connects", "place", "b").where("b.tolerance < 0.2 m").give("connects.length")
    find("goal").without("peer pursues goal").as_of("5 s ago")

A `Find` is a text in parts: `str(find)` is the query, so that what is written in a file, on the command line and in
Python means the same. `knowledge.ask` takes either.
"""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Find:
    """A query in parts; each method gives a new one. Made by `find`.

    Attributes:
        first: The thing that is looked for, as the query calls it.
        pattern: Things and relations.
        conditions: What must hold, each by itself.
        order: What the answers are sorted by; empty for their names.
        most: How many answers at most; 0 for all.
        columns: What is given beside the names.
        moment: As of when; empty for now.
        since: The revision after which something must have changed; None for any.
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
        """And the last thing of the pattern is so related to another: `.link("pursues", "goal")`."""
        *others, last = self.pattern
        return replace(self, pattern=(*others, " ".join(filter(None, (last, relation, kind, name)))))

    def also(self, clause: str) -> Find:
        """And another clause holds, such as `robot at place`."""
        return replace(self, pattern=(*self.pattern, clause))

    def without(self, clause: str) -> Find:
        """And there is nothing such as `peer pursues goal`."""
        return replace(self, pattern=(*self.pattern, f"no {clause}"))

    def where(self, condition: str) -> Find:
        """And an expression holds."""
        return replace(self, conditions=(*self.conditions, condition))

    def within(self, reach: str, of: str = "robot") -> Find:
        """And it is nearer than `reach`, such as `2 m`, to something: a name of the query, a parameter, or a path."""
        return self.where(f"distance({self.first}, {of}) < {reach}")

    def nearest(self, count: int = 1, to: str = "robot") -> Find:
        """The few that are nearest to something."""
        return self.order_by(f"distance({self.first}, {to})").limit(count)

    def order_by(self, measure: str, descending: bool = False) -> Find:
        """Sorted by a number, the least first unless `descending`."""
        return replace(self, order=f"{measure} descending" if descending else measure)

    def limit(self, count: int) -> Find:
        """At most so many answers."""
        return replace(self, most=count)

    def give(self, *columns: str) -> Find:
        """With these values beside the names."""
        return replace(self, columns=(*self.columns, *columns))

    def as_of(self, moment: str) -> Find:
        """As it was at a time, such as `12.5 s` or `5 s ago`."""
        return replace(self, moment=moment)

    def changed_since(self, revision: int) -> Find:
        """Only what has changed after a revision."""
        return replace(self, since=revision)

    def __str__(self) -> str:
        loose = {"or", "if", "implies"}  # what binds less than `and`
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
    """Begin a query: look for variables of a kind, under a name of their own where one is needed."""
    return Find(name or kind, (f"{kind} {name}".strip(),))
