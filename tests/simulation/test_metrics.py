"""What summary.json counts, from events alone."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rocs_bt.cli.outcome import exit_code
from rocs_bt.event import (
    ActuatorCommanded,
    BlockFailed,
    BodyMoved,
    ContactBegan,
    FollowerStepped,
    GoalEntered,
    MinClearanceLowered,
    OutcomeDecided,
    Replanned,
    RuleChanged,
    TicketChanged,
    pack,
)
from rocs_bt.record import AgentInfo, AgentResult, Following, RunHeader, SolveTime, Summary, TrackingError
from rocs_bt.running import Metrics
from rocs_bt.running.metrics import quantile

R2, R3 = (AgentInfo(name=name, robot="pioneer_p3dx", mission="go_to") for name in ("R2", "R3"))


def header(*agents: AgentInfo) -> RunHeader:
    return RunHeader(scenario="one", seed=1, agents=agents)


def command(t: float, route: str) -> ActuatorCommanded:
    return ActuatorCommanded(t=t, agent="R2", actuator="wheels", route=route, data=pack([0.1, 0.1]))


def test_nothing_happened() -> None:
    assert Metrics(header(R2)).of(R2, 9.0) == AgentResult(
        robot="pioneer_p3dx",
        mission="go_to",
        rules=(),
        outcome="interrupted",
        reason="the recording ends at 9.00 s without an outcome",
        goals_reached=0,
        collisions=0,
        struck=0,
        contacts={},
        fell=False,
    )


@pytest.mark.parametrize(
    ("block", "owner", "code", "told"),
    [
        ("wheels", "content", 1, "actuator 'R2/wheels' raised: no"),
        ("plan", "engine", 3, "block 'R2/plan' raised: no"),
        ("actuator wheels", "engine", 3, "block 'R2/actuator wheels' raised: no"),
    ],
)
def test_the_owner_of_what_failed_decides_the_exit_code_and_its_name_does_not(block, owner, code, told) -> None:
    metrics = Metrics(header(R2))
    metrics.emit(BlockFailed(t=1.0, agent="R2", block=block, kind="raised", detail="no", owner=owner))
    found = metrics.of(R2, 2.0)
    assert (found.outcome, found.reason) == ("error", told)
    assert (found.failed_block, found.failed_owner) == (block, owner)
    summary = Summary(scenario="exp1", seed=1, mode="lockstep", sim_time=2.0, agents={"R2": found})
    assert exit_code(summary) == code


def test_everything_is_counted_for_its_own_agent() -> None:
    metrics = Metrics(header(R2, R3))
    for x in (0.0, 0.3, 0.0):
        metrics.emit(BodyMoved(t=x, agent="R2", body="R2", x=x, y=0.0, yaw=0.0))
    metrics.emit(BodyMoved(t=0.0, body="R1", x=9.0, y=0.0, yaw=0.0))
    for distance in (0.5, 0.2):
        metrics.emit(MinClearanceLowered(t=0.0, agent="R2", other="box", distance=distance))
    metrics.emit(ContactBegan(t=0.0, agent="R2", other="box", kind="collision"))
    metrics.emit(ContactBegan(t=0.0, agent="R2", other="R1", kind="struck"))
    for phase in ("latched", "fired", "updated", "fired again", "released", "ended"):
        metrics.emit(RuleChanged(t=0.0, agent="R2", rule="r", phase=phase, priority=1))
    metrics.emit(Replanned(t=0.0, agent="R2", node="GoTo", count=1))
    for state in ("QUEUED", "RUNNING", "CANCELLED"):
        metrics.emit(
            TicketChanged(t=0.0, agent="R2", ticket=1, action="GoTo", priority="NORMAL", state=state, by="plan")
        )
    metrics.emit(GoalEntered(t=1.0, agent="R2", goal="dock", distance=0.05))
    metrics.emit(GoalEntered(t=2.0, agent="R2", goal="dock", distance=0.05))
    for cross, solve in ((0.03, 1e-4), (-0.04, 0.0)):
        metrics.emit(
            FollowerStepped(t=0.0, agent="R2", cross_track=cross, heading_error=0.0, rung="solved", solve_time=solve)
        )
    metrics.emit(OutcomeDecided(t=3.0, agent="R2", outcome="success", time_to_goal=3.0, fell=True))
    found = metrics.of(R2, 9.0)
    assert found.path_length == pytest.approx(0.6)
    assert found.min_clearance == 0.2
    assert (found.collisions, found.struck) == (1, 1)
    assert (found.reflex_activations, found.reflex_refirings) == (1, 1)
    assert (found.replans, found.goals_reached) == (1, 1)
    assert found.actions == {"GoTo": {"CANCELLED": 1}}
    assert found.tracking_error == TrackingError(cross_rms=pytest.approx(math.sqrt(0.00125)), cross_max=0.04)
    assert found.solve_time == SolveTime(median=1e-4, p99=1e-4)
    assert (found.outcome, found.time_to_goal, found.fell) == ("success", 3.0, True)
    assert metrics.of(R3, 9.0) == Metrics(header(R3)).of(R3, 9.0)


def test_time_goes_to_the_route_that_commands() -> None:
    metrics = Metrics(header(R2))
    routes = ["deliberative"] * 4 + ["reactive"] * 2 + ["idle"] + ["reactive"] + ["deliberative"]
    for i, route in enumerate(routes):
        metrics.emit(command(0.05 * i, route))
    found = metrics.of(R2, 9.0)
    assert found.time_deliberative == pytest.approx(0.2)
    assert found.time_reactive == pytest.approx(0.15)
    assert found.route_switches == 2


def test_a_command_counts_no_longer_than_the_watchdog_lets_it() -> None:
    metrics = Metrics(header(R2))
    metrics.emit(command(0.0, "reactive"))
    metrics.emit(command(10.0, "reactive"))
    assert metrics.of(R2, 9.0).time_reactive == pytest.approx(0.2)


def test_quantiles_are_values_that_occurred() -> None:
    values = [float(v) for v in range(100, 0, -1)]
    assert (quantile(values, 0.5), quantile(values, 0.99), quantile([], 0.5)) == (51.0, 100.0, None)


def followed(*rows: tuple[float, float, float], arrived: float | None = None, rim: float = 0.0) -> Any:
    """What is said of R3, which follows R2 at 1.4 m and not nearer than 0.8 m, along x: rows of t, x of R2, x of R3."""
    metrics = Metrics(header(R2, R3))
    parameters = {"leader": "R2", "distance": 1.4, "safety": 0.8}
    ticket = TicketChanged(
        t=0.0,
        agent="R3",
        ticket=1,
        action="FollowRobot",
        priority="NORMAL",
        state="QUEUED",
        by="x",
        parameters=parameters,
    )
    metrics.emit(ticket)
    for t, leader, follower in rows:
        metrics.emit(BodyMoved(t=t, agent="R2", body="R2", x=leader, y=0.0, yaw=0.0))
        metrics.emit(BodyMoved(t=t, agent="R3", body="R3", x=follower, y=0.0, yaw=0.0, wheels=pack([0.0, -rim])))
    metrics.emit(OutcomeDecided(t=9.0, agent="R2", outcome="success", time_to_goal=arrived))
    assert metrics.of(R2, 9.0).following is None
    return metrics.of(R3, 9.0).following


def test_a_follower_is_measured_from_when_it_has_caught_up_until_its_leader_has_arrived() -> None:
    rows = (0.0, 3.0, 0.0), (1.0, 3.0, 1.1), (2.0, 3.0, 1.5), (3.0, 3.0, 0.5), (4.0, 3.0, 2.9)
    # 3.0 m is not caught up yet; then the errors are 0.5, 0.1, 1.1 (too far) and -1.3 m (too near).
    found = followed(*rows)
    assert found == Following(
        leader="R2",
        periods=4,
        mean_distance=pytest.approx((1.9 + 1.5 + 2.5 + 0.1) / 4),
        distance_error=pytest.approx((0.5 + 0.1 + 1.1 + 1.3) / 4),
        in_band=pytest.approx(2 / 4),
        too_far=pytest.approx(1 / 4),
        least_distance=pytest.approx(0.1),
        least_driving=None,
        safe=True,
    )
    arrived = followed(*rows, arrived=2.0)
    assert (arrived.periods, arrived.in_band, arrived.too_far) == (2, 1.0, 0.0)
    assert arrived.distance_error == pytest.approx(0.3)


def test_a_follower_that_never_caught_up_has_no_error_but_is_told() -> None:
    found = followed((0.0, 3.0, 0.0))
    assert (found.leader, found.periods) == ("R2", 0)
    assert {
        getattr(found, name) for name in ("mean_distance", "distance_error", "in_band", "too_far", "least_distance")
    } == {None}


@pytest.mark.parametrize(("rim", "least", "safe"), [(0.3, 0.5, False), (0.01, None, True)])
def test_too_near_counts_while_it_drives_and_not_while_it_is_pushed(
    rim: float, least: float | None, safe: bool
) -> None:
    found = followed((0.05, 3.0, 2.5), rim=rim)
    assert (found.least_driving, found.safe) == (least, safe)
