"""`rocs-bt knowledge keys`."""

from rocs_bt.cli.main import call

from .. import needs

needs.package("cryptography")


def test_keys_are_made_for_each_member_and_later_ones_join_the_group(tmp_path, capsys):
    out = str(tmp_path / "keys")
    assert call(["knowledge", "keys", "R2", "R3", "--out", out]) == 0
    assert "R3: keys of R3" in capsys.readouterr().out
    secret = (tmp_path / "keys/group.key").read_bytes()
    assert call(["knowledge", "keys", "R4", "--out", out]) == 0
    for name in ("R2", "R3", "R4"):
        assert {f.name for f in (tmp_path / "keys" / name).iterdir()} == {
            "authority.pem",
            "group.key",
            "member.key",
            "member.pem",
        }
        assert (tmp_path / "keys" / name / "group.key").read_bytes() == secret


def test_keys_are_not_overwritten(tmp_path, capsys):
    assert call(["knowledge", "keys", "R2", "--out", str(tmp_path)]) == 0
    assert call(["knowledge", "keys", "R2", "--out", str(tmp_path)]) == 2
    assert "'R2' has keys already" in capsys.readouterr().err
