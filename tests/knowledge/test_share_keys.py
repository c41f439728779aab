"""Key files are validated when they are read: each file with each kind of damage is named."""

import shutil
from datetime import UTC, datetime, timedelta

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.share.keys import VALID, MemberKeys, make_keys

from .. import needs

needs.package("cryptography")

MEMBER = ("authority.pem", "member.pem", "member.key", "group.key")
GROUP = ("authority.key", "authority.pem", "group.key")
HEAD = b"-----BEGIN CERTIFICATE-----\nbm90aGluZw==\n-----END CERTIFICATE-----\n"
ENCRYPTED = b"-----BEGIN ENCRYPTED PRIVATE KEY-----\nbm90aGluZw==\n-----END ENCRYPTED PRIVATE KEY-----\n"
DAMAGES = {
    "empty": lambda content: b"",
    "half": lambda content: content[: len(content) // 2],
    "text": lambda content: b"a key\n",
    "binary": lambda content: bytes(range(256)),
    "no certificate": lambda content: HEAD,
    "no key": lambda content: ENCRYPTED,
}


@pytest.fixture(scope="module")
def keys(tmp_path_factory):
    """Folders of two groups, with two members in the first one, and one whose certificates have expired."""
    root = tmp_path_factory.mktemp("keys")
    make_keys(root / "one", ["R1", "R2"], datetime.now(UTC))
    make_keys(root / "two", ["R1"], datetime.now(UTC))
    make_keys(root / "old", ["R1"], datetime.now(UTC) - VALID - timedelta(days=1))
    make_keys(root / "future", ["R1"], datetime.now(UTC) + timedelta(days=10))
    return root


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", MEMBER)
def test_a_damaged_file_of_a_member_is_named_with_what_to_do(keys, tmp_path, name, damage):
    folder = shutil.copytree(keys / "one/R1", tmp_path / "R1")
    assert MemberKeys.read(folder).secret == (folder / "group.key").read_bytes()
    (folder / name).write_bytes(DAMAGES[damage]((folder / name).read_bytes()))
    with pytest.raises(InputError, match=rf"{name}' .*rocs-bt knowledge keys"):
        MemberKeys.read(folder)


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", GROUP)
def test_a_damaged_file_of_a_group_is_named_when_a_member_joins(keys, tmp_path, name, damage):
    folder = shutil.copytree(keys / "one", tmp_path / "one")
    (folder / name).write_bytes(DAMAGES[damage]((folder / name).read_bytes()))
    with pytest.raises(InputError, match=name):
        make_keys(folder, ["R3"], datetime.now(UTC))
    (folder / name).unlink()
    if name != "authority.key":  # a folder without it is that of a new group
        with pytest.raises(InputError, match=rf"lacks {name}"):
            make_keys(folder, ["R3"], datetime.now(UTC))
    assert not (folder / "R3").exists()


@pytest.mark.parametrize(
    ("name", "source", "said"),
    [
        ("member.key", "one/R2/member.key", r"'.*member\.key' is not the key of '.*member\.pem'"),
        ("member.pem", "one/R2/member.pem", r"'.*member\.key' is not the key of '.*member\.pem'"),
        ("member.pem", "one/R1/member.key", r"'.*member\.pem' holds no certificate in PEM form"),
        ("member.key", "one/R1/member.pem", r"'.*member\.key' holds no private key in PEM form"),
        ("authority.pem", "two/R1/authority.pem", r"'.*member\.pem' is not of the group of '.*authority\.pem'"),
        ("authority.pem", "one/R2/member.pem", r"'.*member\.pem' is not of the group of '.*authority\.pem'"),
    ],
)
def test_files_that_do_not_belong_together_are_refused(keys, tmp_path, name, source, said):
    folder = shutil.copytree(keys / "one/R1", tmp_path / "R1")
    shutil.copy(keys / source, folder / name)
    with pytest.raises(InputError, match=said):
        MemberKeys.read(folder)


@pytest.mark.parametrize("group", ["old", "future"])
def test_keys_that_are_not_valid_today_are_refused(keys, group):
    with pytest.raises(InputError, match=r"member\.pem' is valid from \d{4}.*today is.*make new keys"):
        MemberKeys.read(keys / group / "R1")


def test_without_its_library_keys_say_what_to_install(keys, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    for use in (lambda: MemberKeys.read(keys / "one/R1"), lambda: make_keys(keys / "new", ["R1"], datetime.now(UTC))):
        with pytest.raises(InputError, match=r"keys need 'cryptography'.*pip install 'rocs_bt\[share\]'"):
            use()
