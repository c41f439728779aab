"""Changes of the files of a test."""

from pathlib import Path


def edit(file: Path, old: str, new: str) -> None:
    """Put one text in place of another, which must be there."""
    text = file.read_text("utf-8")
    assert old in text, f"no {old!r} in {file}"
    file.write_text(text.replace(old, new), "utf-8")
