"""`rocs-bt check --strict`: a warning fails, a note does not."""

import json

import pytest

HEAD = 'format = "reflex/1"\n[rule.A]\npriority = 1\n'
ACTION = '[rule.A.action]\nname = "Stop"\n'
FILES = {
    "fine": 'when = "speed > 0.4 m/s"\nuntil = "speed < 0.3 m/s"\n',
    "doubtful": 'when = "min(front) < 0.4 m"\nuntil = "min(front) > 0.3 m"\n',
    "undecided": 'when = "once(speed > 1 m/s, 2 s) and speed < 0.5 m/s"\n',
    "wrong": 'when = "min(frnt) < 0.4 m"\n',
}


def check(rocs_bt, folder, which, *options):
    file = folder / "rules.toml"
    file.write_text(HEAD + FILES[which] + ACTION, encoding="utf-8")
    return rocs_bt("check", str(file), *options)


@pytest.mark.parametrize(
    ("which", "code", "strict", "summary"),
    [
        ("fine", 0, 0, "1 file checked: no faults."),
        ("doubtful", 0, 2, "1 file checked: 0 errors, 1 warning."),
        ("undecided", 0, 0, "1 file checked: 0 errors, 0 warnings, 1 note."),
        ("wrong", 2, 2, "1 file checked: 1 error, 0 warnings."),
    ],
)
def test_strict_counts_warnings_as_faults_but_not_notes(rocs_bt, tmp_path, which, code, strict, summary):
    lenient, held = check(rocs_bt, tmp_path, which), check(rocs_bt, tmp_path, which, "--strict")
    assert (lenient.code, held.code) == (code, strict), held.out
    assert summary in held.out
    assert ("note: cannot decide" in held.out) is (which == "undecided")
    assert ("for example with front[0] =" in held.out) is (which == "doubtful")


def test_json_tells_notes_from_warnings(rocs_bt, tmp_path):
    (fault,) = json.loads(check(rocs_bt, tmp_path, "undecided", "--json").out)["faults"]
    assert (fault["warning"], fault["note"], fault["line"], fault["column"]) == (True, True, 4, 9)
