"""Network between processes and hosts over zenoh (extra `share`). Without keys it works on one host only."""

from __future__ import annotations

import ipaddress
import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..base.errors import Fault, InputError
from .keys import MemberKeys
from .network import Link
from .wire import FRAME_LIMIT

if TYPE_CHECKING:
    import zenoh

LEASE = 1000
"""Time without data after which a peer counts as lost [ms]; a killed process is noticed at once."""

_ROOT = "rocs"


class ZenohNetwork:
    """Mesh network of processes. Each listens at an address and needs the addresses of only some others.

    Args:
        listen: Address `host:port` of this process. Port 0 chooses a free port, which only the listed peers get to
            know.
        peers: Addresses of other peers, which need not be running yet.
        keys: Keys for mutual TLS; without them only loopback addresses are allowed.
        group: Name of the group; groups are isolated from each other.

    Raises:
        InputError: zenoh is not installed, an address is invalid, or it is not on loopback and there are no keys.
    """

    def __init__(
        self, listen: str, peers: Sequence[str] = (), *, keys: MemberKeys | None = None, group: str = "robots"
    ) -> None:
        for address in (listen, *peers):
            check_address(address, private=keys is not None)
        try:
            import zenoh
        except ModuleNotFoundError as error:
            hint = "Install it with: pip install 'rocs_bt[share]'"
            raise InputError(
                Fault("sharing between processes needs zenoh, which is not installed.", hint=hint)
            ) from error
        self._zenoh = zenoh
        self._root = f"{_ROOT}/{group}"
        self._links = 0
        try:
            self._session = zenoh.open(zenoh.Config.from_json5(json.dumps(_settings(listen, peers, keys))))
        except zenoh.ZError as error:
            raise InputError(
                f"cannot share at '{listen}': {error}. Is the address taken by another process?"
            ) from error

    def join(self, origin: str, deliver: Callable[[bytes], None], lost: Callable[[str], None]) -> Link:
        """Join the network; the zenoh session ends when the last agent of this process leaves."""
        self._links += 1
        return _ZenohLink(self._zenoh, self._session, self._root, origin, deliver, lost, self._left)

    def _left(self) -> None:
        self._links -= 1
        if not self._links:
            self._session.close()  # type: ignore[no-untyped-call]  # zenoh has no types


class _ZenohLink:
    def __init__(
        self,
        module: Any,
        session: zenoh.Session,
        root: str,
        origin: str,
        deliver: Callable[[bytes], None],
        lost: Callable[[str], None],
        left: Callable[[], None],
    ) -> None:
        self._zenoh = module
        self._left = left
        self._session = session
        self._to_all, self._to_one = f"{root}/all/{_escaped(origin)}", f"{root}/to"

        def take(sample: zenoh.Sample) -> None:
            # An oversized frame is not copied: the inbox only needs its excessive length to reject it.
            payload = sample.payload
            deliver(payload.to_bytes() if len(payload) <= FRAME_LIMIT else bytes(FRAME_LIMIT + 1))

        def alive(sample: zenoh.Sample) -> None:
            if sample.kind == module.SampleKind.DELETE:
                lost(_unescaped(str(sample.key_expr).rpartition("/")[2]))

        here = f"{root}/here"
        self._declared: list[Any] = [
            session.declare_subscriber(f"{root}/all/*", take),
            session.declare_subscriber(f"{self._to_one}/{_escaped(origin)}", take),
            session.liveliness().declare_subscriber(f"{here}/*", alive),
            session.liveliness().declare_token(f"{here}/{_escaped(origin)}"),
        ]

    def send(self, frame: bytes, to: str | None = None) -> None:
        key = self._to_all if to is None else f"{self._to_one}/{_escaped(to)}"
        try:
            # Frames that exceed the capacity are dropped and requested again, so that no peer waits for a slow one.
            self._session.put(key, frame, congestion_control=self._zenoh.CongestionControl.DROP, express=True)
        except self._zenoh.ZError:
            return  # the connection is down; heartbeats resume when it is up again

    def poll(self) -> None:
        """Do nothing: zenoh's threads deliver frames."""

    def close(self) -> None:
        for declared in reversed(self._declared):
            declared.undeclare()
        self._left()


def check_address(address: str, *, private: bool) -> None:
    """Check an address `host:port`.

    Raises:
        InputError: The address is invalid, or not on this host although the connection is not private.
    """
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdecimal() or int(port) > 65535 or not host:
        raise InputError(Fault(f"'{address}' is not an address.", hint="Write host:port, as in 127.0.0.1:7447."))
    if not private and not _loopback(host):
        raise InputError(
            Fault(
                f"'{address}' is not on this host; sharing with other hosts needs keys.",
                hint='Make them with `rocs-bt knowledge keys NAME...` and name the folder: keys = "keys/NAME".',
            )
        )


def _loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def _settings(listen: str, peers: Sequence[str], keys: MemberKeys | None) -> dict[str, Any]:
    line = "tcp" if keys is None else "tls"
    link: dict[str, Any] = {"tx": {"lease": LEASE, "keep_alive": 4}, "rx": {"max_message_size": 16 * FRAME_LIMIT}}
    if keys is not None:
        link["tls"] = {
            "root_ca_certificate": str(keys.authority),
            "listen_private_key": str(keys.key),
            "listen_certificate": str(keys.certificate),
            "connect_private_key": str(keys.key),
            "connect_certificate": str(keys.certificate),
            "enable_mtls": True,
            "verify_name_on_connect": False,  # a robot's address changes; the group's signature does not
        }
        link["protocols"] = ["tls"]
    return {
        "mode": "peer",
        "listen": {"endpoints": [f"{line}/{listen}"]},
        "connect": {
            "endpoints": [f"{line}/{peer}" for peer in peers],
            "timeout_ms": {"peer": -1},
            "exit_on_failure": {"peer": False},
            "retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2},
        },
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": True}},
        "transport": {"link": link},
    }


def _escaped(origin: str) -> str:
    return origin.encode().hex()


def _unescaped(name: str) -> str:
    try:
        return bytes.fromhex(name).decode()
    except ValueError:
        return ""
