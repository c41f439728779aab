"""Table `[share]` of a scenario, and the set-up of knowledge sharing between its agents."""

from __future__ import annotations

import math
import secrets
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated

from ..base.clock import Clock, SimulatedClock
from ..base.errors import Fault, InputError, located_at
from ..base.units import FREQUENCY, TIME, Bounds
from ..catalog import ScenarioSpec
from ..declare import Names, Valid, Value, location_of
from ..knowledge import Knowledge, Schema
from ..simulation.random_streams import NETWORK, stream
from .keys import MemberKeys
from .network import Impairments, LocalNetwork, Network, SimulatedNetwork
from .scope import SharingScope
from .sharing import Ageing, Sharing
from .zenoh_network import ZenohNetwork, check_address

Join = Callable[[Knowledge], Sharing]
"""Function that sets up sharing of an agent's knowledge."""

_PATIENCE = Annotated[float, TIME, Bounds(0.0, infinite=True)]
_DELAY = Annotated[float, TIME, Bounds(0.0, 60.0)]
_GROUP = Valid(str.isidentifier, "a valid group name", "Use letters, digits and '_', beginning with a letter.")


class ShareSpec(Value):
    """`[share]` table: knowledge shared between agents. A scenario without it shares nothing.

    Attributes:
        agents: Names of the agents that share.
        kinds: Shared kinds of nodes; `all` for the whole graph; the kinds of the world by default.
        relations: Shared relations; all relations between shared kinds by default.
        private: Kinds, relations and nodes that are never sent.
        rate: Maximum send rate of an agent [Hz].
        lost_after: Time after which pose and motion of a vanished robot count as unknown [s].
        forget_after: Time after which all other facts from a vanished robot are dropped [s].
        latency: Latency of messages in lockstep [s].
        jitter: Maximum additional latency in lockstep [s].
        loss: Fraction of messages lost in lockstep [1].
        listen: Address of this process, `host:port`; empty to share within this process only.
        peers: Addresses of other processes.
        keys: Folder of this process' keys; None on loopback.
        group: Name of the group; groups on one network are separate.
    """

    agents: Annotated[tuple[str, ...], Names("agent", "no agent", all=True)] = ()
    kinds: tuple[str, ...] = ()
    relations: tuple[str, ...] = ()
    private: tuple[str, ...] = ()
    rate: Annotated[float, FREQUENCY, Bounds(0.1, 1000.0)] = 50.0
    lost_after: _PATIENCE = 3.0
    forget_after: _PATIENCE = math.inf
    latency: _DELAY = 0.0
    jitter: _DELAY = 0.0
    loss: Annotated[float, Bounds(0.0, 1.0, below=True)] = 0.0
    listen: str = ""
    peers: tuple[str, ...] = ()
    keys: Path | None = None
    group: Annotated[str, _GROUP] = "robots"


def sharing_of(scenario: ScenarioSpec, clock: Clock, seed: int) -> dict[str, Join]:
    """Functions that set up knowledge sharing for each agent, by agent, of a scenario with a table `[share]`.

    In lockstep the agents share over a network inside the process, so that a run is repeatable. On wall time they also
    share with other processes, if the table declares an address.

    Raises:
        InputError: Unknown kind or relation, or unusable address.
    """
    spec: ShareSpec = scenario.tables["share"]
    repeats = isinstance(clock, SimulatedClock)
    with located_at(scenario.file, location_of(spec).line):
        network, key = _network(scenario, spec, clock, seed)

    def join(knowledge: Knowledge) -> Sharing:
        with located_at(scenario.file, location_of(spec).line):
            scope = SharingScope(knowledge.graph.schema, spec.kinds, spec.relations, spec.private)
        return Sharing(
            knowledge,
            scope,
            network,
            origin=f"{knowledge.agent}#{'0' if repeats else secrets.token_hex(8)}",
            calendar=clock.now if repeats else time.time,
            key=key,
            ageing=Ageing(spec.lost_after, spec.forget_after),
            gap=1.0 / spec.rate,
        )

    return dict.fromkeys(spec.agents, join)


def share_faults(scenario: ScenarioSpec, schema: Schema) -> list[Fault]:
    """Faults in a scenario's `[share]` table with respect to the schema and the network."""
    spec, faults = scenario.tables["share"], list[Fault]()
    checks: list[Callable[[], object]] = [lambda: SharingScope(schema, spec.kinds, spec.relations, spec.private)]
    addresses = [spec.listen, *spec.peers] if spec.listen else []
    checks += [partial(check_address, address, private=spec.keys is not None) for address in addresses]
    for check in checks:
        try:
            check()
        except InputError as error:
            faults += error.at(scenario.file, location_of(spec).line).faults
    return faults


def _network(scenario: ScenarioSpec, spec: ShareSpec, clock: Clock, seed: int) -> tuple[Network, bytes]:
    """Create the network; returns it with the secret of its members, which is empty without encryption."""
    if isinstance(clock, SimulatedClock):
        impairments = Impairments(spec.loss, spec.latency, spec.jitter)
        if impairments == Impairments():
            return LocalNetwork(), b""
        return SimulatedNetwork(clock.now, stream(scenario.name, seed, "", NETWORK), impairments), b""
    if not spec.listen:
        return LocalNetwork(), b""
    keys = None if spec.keys is None else MemberKeys.read(spec.keys)
    return ZenohNetwork(spec.listen, spec.peers, keys=keys, group=spec.group), b"" if keys is None else keys.secret
