"""Counts of what plain language avoids: they can only fall.

`python tests/docs/plain_language.py` writes the counts of now into plain_language.json, after an improvement.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CEILINGS = Path(__file__).with_suffix(".json")
FOLDERS = ("rocs_bt", "planners", "robots", "scenarios", "examples")
LONG = 30
"""Words of the longest good sentence."""
GENERATED = ("actions.md",)
OPENER = re.compile(
    r"(what|who|whom|whose|how|where|when|which|why|from|in|at|of|by|to|with|on|for|after|before|as)\b", re.IGNORECASE
)
ENTRY = re.compile(r"^    \*{0,2}\w+(?: \([^)]*\))?: (.+)$")
WORDS = {
    "told": r"\btold\b",
    "mind": r"\bminds?\b",
    "who": r"\b(who|whom|whose)\b",
    "nobody": r"\b(nobody|somebody)\b",
    "anew": r"\banew\b",
    "comes to": r"\b(came|comes?) to\b(?! (be|the end))",
    "news": r"\bnews\b",
    "leash": r"\bleash\b",
    "stands": r"\b(stands?|stood)\b",
    "ways": r"\bways\b",
    "as it is": r"\bas it (is|was)\b",
    "left alone": r"\bleft alone\b",
    "stand-in": r"\bstand[- _]in\b",
    "what it is": r"\bwhat (it|they|a|an|the) \w+( \w+)? (is|are|was|were|knows?|says?|has|have)\b",
}


def pages() -> list[Path]:
    """Pages of prose, without the generated ones."""
    found = [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md", *ROOT.glob("*/README.md")]
    return sorted({p for p in found if p.name not in GENERATED})


def modules() -> list[Path]:
    """Python files of the package and of the content folders."""
    return [p for folder in FOLDERS for p in sorted((ROOT / folder).rglob("*.py")) if "_manual" not in p.parts]


def odd_entries(text: str) -> Iterator[str]:
    """Entries of Google-style docstrings of a module that begin with a question word or a preposition."""
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        inside = False
        for line in (ast.get_docstring(node) or "").splitlines():
            if line.strip() and not line.startswith(" "):
                inside = line.strip() in ("Args:", "Attributes:", "Returns:", "Yields:")
            elif inside and (entry := ENTRY.match(line)) and OPENER.match(entry[1]):
                yield entry[1]


def sentences(text: str) -> Iterator[str]:
    """Sentences of a page: no code, headings, tables, comments, and no targets of links; a list item is on its own."""
    text = re.sub(r"^(```+|~~~+).*?^\1", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"^ *(#|\||:::).*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"\]\([^)]*\)|`[^`\n]*`", lambda found: "]" if found[0][0] == "]" else "code", text)
    for paragraph in re.split(r"\n\s*\n|^\s*(?:[-*]|\d+\.) ", text, flags=re.MULTILINE):
        for sentence in re.split(r"(?<=[.!?])[)\"*]*\s+", paragraph):
            if sentence.strip():
                yield " ".join(sentence.split())


def counts() -> dict[str, int]:
    """All counts of the checkout."""
    code, prose = ([path.read_text("utf-8") for path in group] for group in (modules(), pages()))
    lines = [line for text in (*code, *prose) for line in text.splitlines()]
    return {
        "entries that begin with a question word or a preposition": sum(len([*odd_entries(t)]) for t in code),
        **{f"lines with '{name}'": sum(bool(re.search(p, line)) for line in lines) for name, p in WORDS.items()},
        f"sentences over {LONG} words": sum(len(s.split()) > LONG for text in prose for s in sentences(text)),
    }


if __name__ == "__main__":
    CEILINGS.write_text(json.dumps(counts(), indent=2) + "\n", "utf-8")
