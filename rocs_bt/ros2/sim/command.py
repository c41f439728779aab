"""`rocs-bt sim`: simulate the robots of a scenario for another program that drives them."""

from __future__ import annotations

import math
from contextlib import closing, nullcontext
from typing import TYPE_CHECKING

import click

from ...base.errors import Fault, InputError
from ...base.units import NONE, NOT_NEGATIVE, POSITIVE
from ...base.words import counted
from ...cli.content import catalog_for, no_code_option
from ...cli.options import QuantityType
from ...cli.terminal import discard_if_closed, echo, show_table
from ...event import CommandExpired, ContactBegan, Event

if TYPE_CHECKING:
    from ...simulation.viewer import Viewer
    from .simulation import Ros2Simulation, SimulationEnd

_NOTICE = "\n{signal}: stopping the robots.\n"
_SLOW = 0.95  # fraction of the requested rate below which a simulation was too slow


@click.command()
@click.argument("scenario")
@click.option("--ros2", is_flag=True, help="Simulate the robots as ROS 2 robots.")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of the start poses.")
@click.option(
    "--rate",
    type=QuantityType(NONE, NOT_NEGATIVE),
    default=1.0,
    show_default=True,
    help="Speed relative to real time; 0: as fast as possible.",
)
@click.option("--for", "duration", type=QuantityType(bounds=POSITIVE), help="End after this simulated time.")
@click.option("--namespace", default="", help="Namespace of the topics and prefix of the frames.")
@click.option(
    "--cmd-vel",
    type=click.Choice(["TwistStamped", "Twist"]),
    default="TwistStamped",
    show_default=True,
    help="Message type of the topic cmd_vel.",
)
@click.option(
    "--command-timeout",
    "timeout",
    type=QuantityType(bounds=POSITIVE),
    default=0.5,
    show_default=True,
    help="A robot stops without a new command for this simulated time.",
)
@click.option(
    "--network",
    type=click.Choice(["loopback", "lan"]),
    default="loopback",
    show_default=True,
    help="Nodes on this computer only, or on the local network.",
)
@click.option(
    "--transport",
    type=click.Choice(["auto", "rclpy", "dds"]),
    default="auto",
    show_default=True,
    help="auto: rclpy where it can be imported, else DDS without ROS.",
)
@click.option("--distro", default="jazzy", show_default=True, help="Distribution of ROS 2 on the network.")
@click.option(
    "--map-to-odom/--no-map-to-odom",
    default=True,
    show_default=True,
    help="Publish the transform from map to odom of robots with ground-truth odometry.",
)
@click.option(
    "--odom-to-base/--no-odom-to-base",
    default=True,
    show_default=True,
    help="Publish the transform from odom to base_footprint.",
)
@click.option(
    "--tf-per-namespace", is_flag=True, help="Transforms of each robot on tf of its namespace, frames without a prefix."
)
@click.option("--view", is_flag=True, help="Watch in MuJoCo's viewer.")
@no_code_option
def command(
    scenario: str,
    ros2: bool,
    seed: int,
    rate: float,
    duration: float | None,
    namespace: str,
    cmd_vel: str,
    timeout: float,
    network: str,
    transport: str,
    distro: str,
    map_to_odom: bool,
    odom_to_base: bool,
    tf_per_namespace: bool,
    view: bool,
    no_code: bool,
) -> int:
    """Simulate the world of SCENARIO without its missions and rules: other programs drive the robots.

    Agents may be without a mission. Nodes with a type or quality of service that does not match are named.

    Runs until Ctrl-C, SIGTERM or SIGHUP, and then stops the robots. Exits with 0 after --for, 2 if the input is
    invalid, 3 if the engine failed, 128 + signal if a signal ended it. The ROS domain is that of ROS_DOMAIN_ID.
    """
    from ...declare import checked
    from ...running import StopSignals
    from ..network.connect import open_transport
    from ..settings import Ros2Settings
    from .publishers import FrameOptions
    from .robot import COMMAND_TYPES
    from .simulation import Ros2Simulation

    if not ros2:
        hint = f"Write: rocs-bt sim {scenario} --ros2. To run its missions, write: rocs-bt run {scenario}."
        raise InputError(Fault("rocs-bt sim needs a network for the robots.", hint=hint))
    given = {"transport": transport, "distro": distro, "network": network, "namespace": namespace}
    settings = checked(Ros2Settings, given, "the network")
    catalog = catalog_for(scenario, no_code=no_code)
    spec = catalog.load_scenario(scenario, missions=False)
    with StopSignals(_NOTICE) as signals, closing(open_transport(settings, "rocs_bt_sim")) as opened:
        simulation = Ros2Simulation(
            spec,
            catalog,
            opened,
            _Notices(),
            seed=seed,
            rate=rate,
            namespace=namespace,
            command_type=COMMAND_TYPES[cmd_vel],
            timeout=timeout,
            frames=FrameOptions(map_to_odom, odom_to_base, tf_per_namespace),
            notice=lambda text: echo(text, err=True),
        )
        with _viewer(simulation) if view else nullcontext() as screen:
            _announce(simulation, f"{spec.name}, ROS domain {settings.domain_id}, {network}, {opened.name}", cmd_vel)
            end = simulation.run(duration or math.inf, lambda: signals.reason, screen)
        with discard_if_closed():
            _conclude(simulation, end, rate)
    return 0 if signals.received is None else 128 + signals.received


def _viewer(simulation: Ros2Simulation) -> Viewer:
    from ...simulation.viewer import Viewer

    return Viewer(simulation.simulated.world)


def _announce(simulation: Ros2Simulation, where: str, cmd_vel: str) -> None:
    """Print the topics."""
    echo(f"{where}. Not repeatable: commands arrive by the wall clock.")
    publishers = [*simulation.shared, *(each for robot in simulation.robots for each in robot.names.publishers)]
    rows = [(p.topic, p.type, f"{p.hz:g} Hz" if p.hz else "") for p in publishers]
    show_table(rows, ("publishes", "type", "rate"), right=(2,))
    if simulation.without_tf:
        echo(f"No transforms: {simulation.without_tf}", err=True)
    for robot in simulation.robots:
        echo(f"{robot.names.robot} obeys {robot.command_topic} ({cmd_vel}).")
    echo("Ready. Ctrl-C ends the simulation.")


def _conclude(simulation: Ros2Simulation, end: SimulationEnd, rate: float) -> None:
    """Print the figures of the simulation."""
    factor = end.real_time_factor
    echo(f"Simulated {end.sim_time:.2f} s in {end.wall_time:.2f} s: real-time factor {factor:.2f}, not repeatable.")
    for robot in simulation.robots:
        stops = f", stopped {counted(robot.expired, 'time')} without one" if robot.expired else ""
        echo(f"{robot.names.robot}: {counted(robot.commands, 'command')}{stops}.")
        for name, fault in robot.faults.items():
            echo(f"{robot.names.robot}: {name}: {fault}", err=True)
    if end.skipped and factor < _SLOW * rate:
        echo(f"This computer was too slow for the rate {rate:g}.", err=True)


class _Notices:
    """Event sink that prints contacts, and robots that stopped without commands."""

    def emit(self, event: Event) -> None:
        """Print an event."""
        if isinstance(event, ContactBegan):
            echo(f"{event.t:.2f} s: {event.agent}: {event.kind} with {event.other}", err=True)
        elif isinstance(event, CommandExpired):
            echo(f"{event.t:.2f} s: {event.agent}: no command any more, stopped", err=True)
