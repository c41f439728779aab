"""Set up knowledge sharing between the agents of a scenario, from its `[share]` table."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from functools import partial

from ..base.clock import Clock, SimulatedClock
from ..base.errors import Fault, InputError, located_at
from ..catalog import ScenarioSpec, ShareSpec
from ..declare import place_of
from ..knowledge import Knowledge, Schema
from ..simulation.random_streams import NETWORK, stream
from .keys import Keys
from .network import Impairments, LocalNetwork, Network, SimulatedNetwork
from .scope import Scope
from .sharing import Ageing, Sharing
from .zenoh_network import ZenohNetwork, check_address

Join = Callable[[Knowledge], Sharing]
"""Function that sets up sharing of an agent's knowledge."""


def sharing_of(scenario: ScenarioSpec, clock: Clock, seed: int) -> dict[str, Join]:
    """Functions that set up knowledge sharing for each agent, by agent, of a scenario with a table `[share]`.

    In lockstep the agents share over a network inside the process, so that a run is repeatable. On wall time they also
    share with other processes, if the table declares an address.

    Raises:
        InputError: Unknown kind or relation, or unusable address.
    """
    spec = scenario.share
    assert spec is not None  # the core asks only for scenarios with this table
    repeats = isinstance(clock, SimulatedClock)
    with located_at(scenario.file, place_of(spec).line):
        network, key = _network(scenario, spec, clock, seed)

    def join(knowledge: Knowledge) -> Sharing:
        with located_at(scenario.file, place_of(spec).line):
            scope = Scope(knowledge.graph.schema, spec.kinds, spec.relations, spec.private)
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
    spec, faults = scenario.share, list[Fault]()
    assert spec is not None  # the core asks only for scenarios with this table
    checks: list[Callable[[], object]] = [lambda: Scope(schema, spec.kinds, spec.relations, spec.private)]
    addresses = [spec.listen, *spec.peers] if spec.listen else []
    checks += [partial(check_address, address, private=spec.keys is not None) for address in addresses]
    for check in checks:
        try:
            check()
        except InputError as error:
            faults += error.at(scenario.file, place_of(spec).line).faults
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
    keys = None if spec.keys is None else Keys.read(spec.keys)
    return ZenohNetwork(spec.listen, spec.peers, keys=keys, group=spec.group), b"" if keys is None else keys.secret
