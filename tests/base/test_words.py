"""How counts are told."""

from rocs_bt.words import counted


def test_one_has_no_plural():
    told = [
        counted(1, "scene"),
        counted(0, "scene"),
        counted(2, "scene"),
        counted(2, "switch", "es"),
        counted(1, "x", "es"),
    ]
    assert told == ["1 scene", "0 scenes", "2 scenes", "2 switches", "1 x"]
