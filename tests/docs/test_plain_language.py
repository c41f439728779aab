"""Plain language: no count is above its ceiling, and every ceiling is lowered with its count."""

import json

from .plain_language import CEILINGS, counts, odd_entries, sentences


def test_no_count_rises_and_a_lower_count_lowers_its_ceiling():
    ceilings, now = json.loads(CEILINGS.read_text("utf-8")), counts()
    assert ceilings.keys() == now.keys()
    assert {n: c for n, c in now.items() if c > ceilings[n]} == {}, "plain words, please: these counts have risen"
    lower = {n: c for n, c in now.items() if c < ceilings[n]}
    assert lower == {}, "these counts have fallen; keep them: python tests/docs/plain_language.py"


def test_code_tables_headings_and_links_are_no_sentences():
    page = "# A title\n\nOne [two](three four). Five: six\nseven.\n\n| a | b |\n\n- eight\n- nine\n\n```x\nno.\n```\n"
    assert [*sentences(page)] == ["One [two].", "Five: six seven.", "eight", "nine"]


def test_entries_are_those_of_sections_only():
    text = '"""First.\n\nArgs:\n    a: What it is.\n    b: Name.\n\nRaises:\n    E: When bad.\n"""\n'
    assert [*odd_entries(text)] == ["What it is."]
