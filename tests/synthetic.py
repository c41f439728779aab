"""A made-up run like EXP1: R2 drives from (-1, 2) towards the origin round a box, R1 wanders. No engine needed."""

import math

import msgspec

from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.event import (
    ActuatorCommanded,
    AtomicStarted,
    BodyMoved,
    Change,
    Event,
    FollowerStepped,
    KnowledgeChanged,
    NodeTicked,
    Replanned,
    RuleChanged,
    SensorRead,
    SignalsWritten,
    TicketChanged,
    pack,
)
from rocs_bt.record.file.header import AgentInfo, Beam, BodyInfo, Outline, Place, RunHeader, TreeNode
from rocs_bt.record.file.summary import Summary

PERIOD = 0.05  # [s]
ANGLES = [90, 50, 30, 10, -10, -30, -50, -90, -90, -130, -150, -170, 170, 150, 130, 90]
HULL = tuple((0.22 * math.cos(a) + 0.02, 0.19 * math.sin(a)) for a in [i * math.tau / 16 for i in range(16)])
BOX = Pose2(-0.5, 1.0)


def header(seed: int = 7) -> RunHeader:
    beams = tuple(
        Beam(
            x=0.16 * math.cos(math.radians(a)),
            y=0.14 * math.sin(math.radians(a)),
            yaw=math.radians(a),
            reach=1.0,
            cone=math.radians(30),
        )
        for a in ANGLES
    )
    walls = [
        ((2.5, 0.0), (0.05, 5.0)),
        ((-2.475, 0.0), (0.05, 5.0)),
        ((0.0, 2.5), (5.0, 0.05)),
        ((0.0, -2.45), (5.0, 0.05)),
    ]
    outlines = [Outline.box(f"wall {i}", Pose2(*at), size, 0.5) for i, (at, size) in enumerate(walls)]
    return RunHeader(
        scenario="exp1",
        seed=seed,
        command=f"rocs-bt run exp1 --seed {seed}",
        versions={"rocs_bt": "0.1.0", "mujoco": "4.0.1", "python": "3.11"},
        content_hash="0f" * 32,
        rates={"control": 20.0, "plan": 10.0, "physics": 200.0},
        agents=(
            AgentInfo(
                name="R2",
                robot="pioneer_p3dx",
                mission="go_to",
                rules=("avoid_collision",),
                nodes=(
                    TreeNode(path="go to", type="Sequence", children=("go to/goal known", "go to/GoTo")),
                    TreeNode(path="go to/goal known", type="Known"),
                    TreeNode(path="go to/GoTo", type="Act", ports='(goal="origin")'),
                ),
            ),
        ),
        bodies=(BodyInfo(name="R2", hull=HULL, beams={"sonar": beams}), BodyInfo(name="R1", hull=HULL)),
        outlines=(*outlines, Outline.box("box", BOX, (0.5, 0.5), 0.5), Outline.circle("post", (1.4, -1.2), 0.15, 0.5)),
        places=(Place(name="origin", x=0.0, y=0.0, radius=0.1),),
    )


def ray(x: float, y: float, yaw: float) -> float:
    """Distance to the walls or the box, marched [m]; +inf beyond 1 m."""
    for i in range(0, 101, 2):
        px, py = x + 0.01 * i * math.cos(yaw), y + 0.01 * i * math.sin(yaw)
        if abs(px) > 2.45 or abs(py) > 2.45 or (abs(px - BOX.x) < 0.25 and abs(py - BOX.y) < 0.25):
            return 0.01 * i
    return math.inf


def events(seconds: float = 20.0) -> list[Event]:
    out: list[Event] = []
    pose, r1, ticket, reflex, replans = Pose2(-1.0, 2.0, -0.6), Pose2(1.0, -1.5, 2.0), 1, None, 0
    wheels = (0.0, 0.0)

    def say(event: type[Event], /, **fields) -> None:
        out.append(event(t=t, agent="R2", **fields))

    def ask(action: str, state: str, priority: str, by: str, **parameters) -> None:
        say(
            TicketChanged,
            ticket=ticket,
            action=action,
            state=state,
            priority=priority,
            by=by,
            parameters=parameters,
        )

    for k in range(round(seconds / PERIOD)):
        t = k * PERIOD
        if k == 0:
            say(KnowledgeChanged, what="node added", subject="origin", name="goal", revision=1)
            say(NodeTicked, node="go to", status="RUNNING")
            say(NodeTicked, node="go to/goal known", status="SUCCESS")
            say(NodeTicked, node="go to/GoTo", status="RUNNING")
            ask("GoTo", "QUEUED", "NORMAL", "go to/GoTo", goal="origin", cruise=0.5)
            ask("GoTo", "RUNNING", "NORMAL", "go to/GoTo", goal="origin", cruise=0.5)
        ranges = [ray(pose.x, pose.y, pose.yaw + math.radians(a)) for a in ANGLES]
        front, far = min(ranges[2:6]), math.hypot(pose.x, pose.y)
        say(SensorRead, sensor="sonar", stamp=t, data=pack(ranges))
        say(SensorRead, sensor="position", stamp=t, data=pack(pose))
        say(SensorRead, sensor="encoders", stamp=t, data=pack(wheels))
        say(
            SignalsWritten,
            monitor="sonar",
            signals=("front", "rear"),
            sizes=(4, 4),
            data=pack([*ranges[2:6], *ranges[10:14]]),
        )
        say(SignalsWritten, monitor="position", signals=("pose",), sizes=(3,), data=pack(pose))
        say(SignalsWritten, monitor="encoders", signals=("wheel_speeds",), sizes=(2,), data=pack(wheels))
        if k % 10 == 0:
            say(Change, source="ranges", kind="obstacle", values={"front": front})
        blocked = front < 0.30
        if blocked and reflex is None:
            ask("GoTo", "CANCELLED", "NORMAL", "avoid_collision/AvoidCollision")
            ticket, reflex = ticket + 1, t
            say(
                RuleChanged,
                rule="avoid_collision/AvoidCollision",
                phase="fired",
                priority=10,
                reading=f"min(front) = {front:.2f} m",
                parameters={"turn": 1.047},
            )
            ask("AvoidCollision", "RUNNING", "HIGH", "avoid_collision/AvoidCollision", turn=1.047)
            say(
                AtomicStarted,
                ticket=ticket,
                action="TurnAngle",
                route="reactive",
                parameters={"angle": 1.047},
            )
        elif reflex is not None and not blocked and t - reflex > 0.6:
            ask("AvoidCollision", "SUCCEEDED", "HIGH", "avoid_collision/AvoidCollision")
            say(RuleChanged, rule="avoid_collision/AvoidCollision", phase="ended", priority=10)
            ticket, reflex, replans = ticket + 1, None, replans + 1
            say(Replanned, node="go to/GoTo", count=replans)
            ask("GoTo", "RUNNING", "NORMAL", "go to/GoTo", goal="origin", cruise=0.5)
        if reflex is not None:
            command = (-0.05, 0.25)
        elif far < 0.1:
            command = (0.0, 0.0)
            if out and not any(isinstance(e, NodeTicked) and e.status == "SUCCESS" and e.node == "go to" for e in out):
                ask("GoTo", "SUCCEEDED", "NORMAL", "go to/GoTo")
                say(NodeTicked, node="go to/GoTo", status="SUCCESS")
                say(NodeTicked, node="go to", status="SUCCESS")
        else:
            error = pose.bearing(Pose2(0.0, 0.0) if replans == 0 or pose.y < 0.9 or pose.x > 0.02 else Pose2(0.1, 1.2))
            command = (0.4 - 0.17 * 2.0 * error, 0.4 + 0.17 * 2.0 * error)
            say(FollowerStepped, cross_track=0.01 * math.sin(t), heading_error=error, rung="optimal", solve_time=6e-5)
            if k % 8 == 0:
                say(
                    AtomicStarted,
                    ticket=ticket,
                    action="SetWheelSpeed",
                    route="deliberative",
                    parameters={"speeds": [0.4, 0.4]},
                )
        route = "reactive" if reflex is not None else "deliberative" if far >= 0.1 else "idle"
        say(ActuatorCommanded, actuator="wheels", route=route, data=pack(command))
        wheels = tuple(w + 0.35 * (c - w) for w, c in zip(wheels, command, strict=True))
        speed, turn = sum(wheels) / 2.0, (wheels[1] - wheels[0]) / 0.33
        yaw = wrap_angle(pose.yaw + turn * PERIOD)
        pose = Pose2(pose.x + speed * math.cos(yaw) * PERIOD, pose.y + speed * math.sin(yaw) * PERIOD, yaw)
        r1 = Pose2(1.0 + 0.8 * math.sin(0.21 * t), -1.5 + 0.3 * math.cos(0.35 * t), wrap_angle(0.2 * t))
        out.append(BodyMoved(t=t + PERIOD, body="R2", x=pose.x, y=pose.y, yaw=pose.yaw, wheels=pack(wheels)))
        out.append(BodyMoved(t=t + PERIOD, body="R1", x=r1.x, y=r1.y, yaw=r1.yaw, wheels=pack((0.2, 0.2))))
    return out


def summary(seed: int = 7) -> Summary:
    plain = {
        "scenario": "exp1",
        "seed": seed,
        "mode": "lockstep",
        "sim_time": 20.0,
        "wall_time": 0.31,
        "real_time_factor": 64.5,
        "versions": {"rocs_bt": "0.1.0"},
        "content_hash": "0f" * 32,
        "trajectory_hash": "ab" * 32,
        "agents": {
            "R2": {
                "robot": "pioneer_p3dx",
                "mission": "go_to",
                "rules": ["avoid_collision"],
                "outcome": "success",
                "reason": "the mission succeeded, and R2 stands 0.08 m from origin",
                "time_to_goal": 12.3,
                "goals_reached": 1,
                "path_length": 3.1,
                "min_clearance": 0.11,
                "collisions": 0,
                "struck": 0,
                "reflex_activations": 2,
                "route_switches": 4,
                "time_reactive": 2.4,
                "time_deliberative": 9.9,
                "replans": 2,
                "actions": {"GoTo": {"SUCCEEDED": 1, "CANCELLED": 2}, "AvoidCollision": {"SUCCEEDED": 2}},
                "tracking_error": {"cross_rms": 0.007, "cross_max": 0.02},
                "solve_time": {"median": 6e-5, "p99": 1.2e-4},
            }
        },
    }
    return msgspec.convert(plain, Summary)
