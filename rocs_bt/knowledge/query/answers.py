"""What a query gives back: plain values."""

from __future__ import annotations

from typing import Any

import msgspec


class Answers(msgspec.Struct, frozen=True):
    """All that was found, in the order that the query asks for, and by name where it asks for none.

    It is true where anything was found.

    Attributes:
        things: What the query looked for, by the names that it gives them.
        rows: What was found: a node for each of `things`.
        columns: What `give` asked for, as it was written.
        values: Its values, beside each row; None where one is not known.
    """

    things: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    columns: tuple[str, ...] = ()
    values: tuple[tuple[Any, ...], ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def names(self) -> list[str]:
        """The nodes found for what the query named first, each once."""
        return list(dict.fromkeys(row[0] for row in self.rows if row))

    @property
    def first(self) -> str | None:
        """The first of `names`; None where there is none."""
        return self.rows[0][0] if self.rows and self.rows[0] else None

    @property
    def dicts(self) -> list[dict[str, Any]]:
        """Each answer as a mapping of things and columns."""
        values = self.values or ((),) * len(self.rows)
        return [
            {**dict(zip(self.things, row, strict=True)), **dict(zip(self.columns, given, strict=True))}
            for row, given in zip(self.rows, values, strict=True)
        ]
