"""JSON from outside that nests without end is refused, also under a recursion limit that a deep tree has raised."""

import subprocess
import sys

import pytest

from rocs_bt.base.nesting import LIMIT, check_nesting, too_deep

READERS = {
    "knowledge": "from_json_text('{\"a\": ' + '[' * 200_000, Path('k.json'))",
    "event": 'codec.decode(b\'{"type":"KnowledgeChanged","value":\' + b\'[\' * 200_000)',
}
SCRIPT = """
import sys
from pathlib import Path
from rocs_bt.base.errors import RocsError
from rocs_bt.knowledge.history import from_json_text
from rocs_bt.record.file import codec

sys.setrecursionlimit(1_000_000)
try:
    {call}
except (RocsError, ValueError) as error:
    print(error)
"""


@pytest.mark.parametrize("reader", READERS)
def test_no_nesting_ends_the_process(reader):
    script = SCRIPT.format(call=READERS[reader])
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f"nest more than {LIMIT} deep" in done.stdout


@pytest.mark.parametrize(
    ("text", "deep"),
    [
        ("[" * LIMIT + "]" * LIMIT, False),
        ("[" * (LIMIT + 1) + "]" * (LIMIT + 1), True),
        ("[" + "[]," * 10_000 + "[]]", False),
        ('"' + "[" * 10_000 + '"', False),
        ('["' + '\\"[' * 10_000 + '"]', False),
        ('{"a":' * (LIMIT + 1), True),
    ],
)
def test_lists_and_objects_count_and_what_stands_in_texts_does_not(text, deep):
    assert too_deep(text) == too_deep(text.encode()) == deep
    if deep:
        with pytest.raises(ValueError, match=f"nest more than {LIMIT} deep"):
            check_nesting(text)
