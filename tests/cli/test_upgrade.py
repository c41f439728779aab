"""`rocs-bt upgrade`: what it writes, what it prints, and its exit codes."""

import os
import stat

import pytest

OLD = 'format = "scenario/1"  # old\nworld = "arena"\n[[mover]]\nname = "R9"\n'
NEW = 'format = "scenario/2"  # old\nworld = "arena"\n[[actor]]\nname = "R9"\n'


@pytest.fixture
def old(project):
    """A project's scenario of the old format."""
    file = project / "scenarios/old.toml"
    file.write_text(OLD)
    return file


def test_the_project_is_upgraded_once(rocs_bt, old):
    old.chmod(0o640)
    told = rocs_bt("upgrade")
    assert (told.code, told.out.splitlines()) == (
        0,
        ["scenarios/old.toml:1: scenario/1 -> scenario/2", "scenarios/old.toml:3: mover -> actor", "1 file upgraded."],
    )
    assert old.read_text() == NEW
    assert stat.S_IMODE(old.stat().st_mode) == 0o640
    assert rocs_bt("upgrade", old).out == "0 files upgraded.\n"
    assert not [file for file in os.listdir(old.parent) if file.endswith(".part")]


def test_dry_writes_nothing(rocs_bt, old):
    told = rocs_bt("upgrade", "scenarios", "--dry-run")
    assert told.out.endswith("1 file to upgrade.\n")
    assert old.read_text() == OLD


def test_files_that_cannot_be_upgraded_are_reported_and_left(rocs_bt, old, project):
    bad = old.with_name("bad.toml")
    bad.write_text(OLD + "[[actor]]\nname = 'R8'\n")
    (project / "runs").mkdir()
    (project / "runs/other.toml").write_text("not toml")
    told = rocs_bt("upgrade", ".")
    assert told.code == 2
    assert "scenarios/bad.toml:3:1: 'mover' is the old name of 'actor', and the table has both." in told.out
    assert told.out.endswith("1 file upgraded, 1 left unchanged because of errors.\n")
    assert "other.toml" not in told.out
    assert old.read_text() == NEW
    assert bad.read_text() != NEW


@pytest.mark.parametrize("line", ['"format" = "scenario/1"', 'format = """scenario/1"""', "'format'='scenario/1'"])
def test_a_folder_is_searched_for_the_format_however_it_is_quoted(rocs_bt, old, line):
    old.write_text(OLD.replace('format = "scenario/1"', line))
    old.with_name("link.toml").symlink_to(old)
    told = rocs_bt("upgrade", "--dry-run")
    assert told.out.endswith("1 file to upgrade.\n")


def test_a_link_out_of_the_folder_is_left(rocs_bt, old, tmp_path):
    outside = tmp_path / "outside.toml"
    outside.write_text(OLD)
    old.unlink()
    old.symlink_to(outside)
    assert rocs_bt("upgrade").out == "0 files upgraded.\n"
    assert outside.read_text() == OLD


def test_a_command_on_an_old_file_says_what_to_do(rocs_bt, old):
    told = rocs_bt("run", "old")
    assert told.code == 2
    assert "old.toml:1:1: the format 'scenario/1' is old; the present one is 'scenario/2'." in told.err
    assert "`rocs-bt upgrade scenarios/old.toml` rewrites the file." in told.err


def test_without_a_project_or_a_file_it_says_so(rocs_bt):
    assert "Give a file or a folder" in rocs_bt("upgrade").err
    assert "no file or folder 'none'" in rocs_bt("upgrade", "none").err
