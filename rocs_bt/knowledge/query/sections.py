"""The sections of a query's text: what stands before `where`, after `where`, after `order by`, and so on."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ...errors import Fault, InputError
from ...expression import blank_texts

# In the order in which they must stand.
SECTIONS = ("where", "order by", "limit", "give", "as of", "changed since")
_SECTION = re.compile(r"(?<![\w.])(where|order\s+by|limit|give|as\s+of|changed\s+since)(?!\w)")


@dataclass(frozen=True)
class Section:
    """A part of a query's text.

    Attributes:
        text: The whole query up to the end of this part, all before it blank: a column in it is one of the query.
        start: Where it begins, 0-based.
    """

    text: str
    start: int

    @property
    def words(self) -> str:
        """What stands in it."""
        return self.text[self.start :].strip()

    def fault(self, message: str, hint: str = "", at: int | None = None) -> InputError:
        """A fault of this part, at its first word if no place is given (0-based)."""
        blank = len(self.text[self.start :]) - len(self.text[self.start :].lstrip())
        return InputError(Fault(message, column=1 + (self.start + blank if at is None else at), hint=hint))

    def split(self) -> list[Section]:
        """Its parts between commas that stand in no brackets and no quotes."""
        blanked, depth, begin, parts = blank_texts(self.text), 0, self.start, []
        for at in range(self.start, len(blanked)):
            depth += (blanked[at] in "([") - (blanked[at] in ")]")
            if blanked[at] == "," and depth == 0:
                parts.append(_section(self.text, begin, at))
                begin = at + 1
        return [*parts, _section(self.text, begin, len(self.text))]


def sections_of(text: str) -> dict[str, Section]:
    """The sections of a query by the words that begin them; the pattern's is the empty word.

    Raises:
        InputError: A section stands twice, in another order, or says nothing.
    """
    found: dict[str, Section] = {}
    heads = [("", 0, 0), *((" ".join(m[0].split()), m.start(), m.end()) for m in _SECTION.finditer(blank_texts(text)))]
    ends = [start for _, start, _ in heads[1:]] + [len(text)]
    for (word, start, begin), end in zip(heads, ends, strict=True):
        section = _section(text, begin, end)
        if word in found:
            raise section.fault(f"'{word}' stands twice.", "Join the two by 'and', or drop one.", start)
        if any(SECTIONS.index(other) > SECTIONS.index(word) for other in found if other and word):
            raise section.fault(f"'{word}' stands too late.", f"The order is: {', '.join(SECTIONS)}.", start)
        if word and not section.words:
            raise section.fault(f"nothing stands after '{word}'.", at=start)
        found[word] = section
    return found


def _section(text: str, start: int, end: int) -> Section:
    return Section(re.sub(r"[^\n]", " ", text[:start]) + text[start:end], start)
