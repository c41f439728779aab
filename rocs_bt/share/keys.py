"""Keys of a group of agents: only agents that have a folder of keys of the group can share knowledge.

Each member of the group has its own private key and a certificate, signed by the group's authority, for mutual TLS. All
members have the same secret, with which every message is authenticated. The authority's private key signs the
certificates of new members; do not copy it to robots.
"""

from __future__ import annotations

import importlib.util
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import Fault, InputError
from ..base.files import is_file, read_bytes, write_whole

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey
    from cryptography.x509 import Certificate

AUTHORITY, AUTHORITY_KEY, SECRET = "authority.pem", "authority.key", "group.key"
CERTIFICATE, KEY = "member.pem", "member.key"
VALID = timedelta(days=3650)

_HINT = "Make keys with `rocs-bt knowledge keys NAME...` and copy the folder NAME."
_SECRET_SIZE = 32  # [bytes]
_MOST = 1_000_000  # maximum size of a key file [bytes]


@dataclass(frozen=True)
class MemberKeys:
    """Keys of one member of a group."""

    authority: Path
    certificate: Path
    key: Path
    secret: bytes

    @classmethod
    def read(cls, folder: Path) -> MemberKeys:
        """Read a member's keys from its folder.

        Raises:
            InputError: A file is missing, damaged, of another group or member, or not valid today; or the extra is not
                installed.
        """
        _require_cryptography()
        _require_files(folder, AUTHORITY, CERTIFICATE, KEY, SECRET)
        secret = _secret(folder / SECRET)
        authority, certificate = (_certificate_in(folder / name) for name in (AUTHORITY, CERTIFICATE))
        if _key_in(folder / KEY).public_key() != certificate.public_key():
            raise InputError(Fault(f"'{folder / KEY}' is not the key of '{folder / CERTIFICATE}'.", hint=_HINT))
        _check_issued(folder, certificate, authority)
        return cls(folder / AUTHORITY, folder / CERTIFICATE, folder / KEY, secret)


def make_keys(folder: Path, members: Sequence[str], now: datetime) -> list[Path]:
    """Make keys, valid for ten years, for new members of a group, and for the group itself if it has none.

    Returns the folders to copy to the members.

    Raises:
        InputError: A member has keys already, or its name is not an identifier; a file of the group is damaged or
            missing; or the extra is not installed.
    """
    _require_cryptography()
    for member in members:
        if not member.isidentifier():
            raise InputError(f"'{member}' cannot name a member. Use letters, digits and '_', beginning with a letter.")
        if (folder / member).exists():
            raise InputError(f"'{folder / member}' exists: '{member}' has keys already. Remove it to make new ones.")
    folder.mkdir(parents=True, exist_ok=True)
    key, certificate = _authority(folder, now)
    return [_member(folder, member, key, certificate, now) for member in members]


def _authority(folder: Path, now: datetime) -> tuple[EllipticCurvePrivateKey, Certificate]:
    from cryptography.hazmat.primitives.asymmetric import ec

    if (folder / AUTHORITY_KEY).exists():
        key = _key_in(folder / AUTHORITY_KEY)
        _require_files(folder, AUTHORITY, SECRET)
        certificate = _certificate_in(folder / AUTHORITY)
        if key.public_key() != certificate.public_key():
            raise InputError(f"'{folder / AUTHORITY_KEY}' is not the key of '{folder / AUTHORITY}'.")
        _secret(folder / SECRET)
        return key, certificate
    key = ec.generate_private_key(ec.SECP256R1())
    certificate = _certificate("rocs_bt group", key, None, now)
    _keep(folder / AUTHORITY_KEY, _pem(key))
    _keep(folder / AUTHORITY, _public(certificate))
    _keep(folder / SECRET, secrets.token_bytes(_SECRET_SIZE))
    return key, certificate


def _require_cryptography() -> None:
    if importlib.util.find_spec("cryptography") is None:
        what = "keys need 'cryptography', which is not installed."
        raise InputError(Fault(what, hint="pip install 'rocs_bt[share]'"))


def _require_files(folder: Path, *names: str) -> None:
    if missing := [name for name in names if not is_file(folder / name)]:
        raise InputError(Fault(f"the folder of keys '{folder}' lacks {', '.join(missing)}.", hint=_HINT))


def _secret(file: Path) -> bytes:
    secret = read_bytes(file, _MOST)
    if len(secret) != _SECRET_SIZE:
        raise InputError(Fault(f"'{file}' must hold {_SECRET_SIZE} bytes, found {len(secret)}.", hint=_HINT))
    return secret


def _key_in(file: Path) -> EllipticCurvePrivateKey:
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        key = load_pem_private_key(read_bytes(file, _MOST), None)
    except (ValueError, TypeError, UnsupportedAlgorithm) as error:  # TypeError: a key with a password
        raise InputError(Fault(f"'{file}' holds no private key in PEM form.", hint=_HINT)) from error
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise InputError(Fault(f"'{file}' is not a key made by `rocs-bt knowledge keys`.", hint=_HINT))
    return key


def _certificate_in(file: Path) -> Certificate:
    from cryptography.x509 import load_pem_x509_certificate

    try:
        return load_pem_x509_certificate(read_bytes(file, _MOST))
    except ValueError as error:
        raise InputError(Fault(f"'{file}' holds no certificate in PEM form.", hint=_HINT)) from error


def _check_issued(folder: Path, certificate: Certificate, authority: Certificate) -> None:
    """Check that the authority of the group has signed a member's certificate, and that both are valid today."""
    from cryptography.exceptions import InvalidSignature

    try:
        certificate.verify_directly_issued_by(authority)
    except (ValueError, TypeError, InvalidSignature) as error:
        what = f"'{folder / CERTIFICATE}' is not of the group of '{folder / AUTHORITY}'."
        raise InputError(Fault(what, hint="Copy all files of a member's folder together.")) from error
    now = datetime.now(UTC)
    for name, each in ((CERTIFICATE, certificate), (AUTHORITY, authority)):
        begin, end = each.not_valid_before_utc, each.not_valid_after_utc
        if not begin <= now <= end:
            what = f"'{folder / name}' is valid from {begin:%Y-%m-%d} to {end:%Y-%m-%d}, and today is {now:%Y-%m-%d}."
            raise InputError(Fault(what, hint="Correct the clock of this computer, or make new keys."))


def _member(
    folder: Path, member: str, authority: EllipticCurvePrivateKey, certificate: Certificate, now: datetime
) -> Path:
    from cryptography.hazmat.primitives.asymmetric import ec

    own = folder / member
    own.mkdir()
    key = ec.generate_private_key(ec.SECP256R1())
    _keep(own / KEY, _pem(key))
    _keep(own / CERTIFICATE, _public(_certificate(member, key, (authority, certificate), now)))
    _keep(own / AUTHORITY, _public(certificate))
    _keep(own / SECRET, read_bytes(folder / SECRET))
    return own


def _certificate(
    name: str,
    key: EllipticCurvePrivateKey,
    issuer: tuple[EllipticCurvePrivateKey, Certificate] | None,
    now: datetime,
) -> Certificate:
    """A certificate signed by the issuer, or self-signed; valid for clients and servers."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    signer, issued_by = (key, subject) if issuer is None else (issuer[0], issuer[1].subject)
    uses = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH])
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issued_by)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))  # tolerance for wrong clocks of robots
        .not_valid_after(now + VALID)
        .add_extension(x509.BasicConstraints(ca=issuer is None, path_length=None), critical=True)
        .add_extension(x509.SubjectAlternativeName([x509.DNSName(name.replace(" ", "-").replace("_", "-"))]), False)
    )
    if issuer is not None:
        builder = builder.add_extension(uses, critical=False)
    return builder.sign(signer, hashes.SHA256())


def _pem(key: EllipticCurvePrivateKey) -> bytes:
    from cryptography.hazmat.primitives import serialization as form

    return key.private_bytes(form.Encoding.PEM, form.PrivateFormat.PKCS8, form.NoEncryption())


def _public(certificate: Certificate) -> bytes:
    from cryptography.hazmat.primitives.serialization import Encoding

    return certificate.public_bytes(Encoding.PEM)


def _keep(file: Path, content: bytes) -> None:
    write_whole(file, content, mode=0o600)
