"""Battery of the quadrotor: charge, drained by the power of the rotors."""

from __future__ import annotations

import math

from rocs_bt import Joules, Metres, Watts
from rocs_bt.devices.mujoco import MujocoSensor

AIR = 1.225  # [kg/m3] density of air at sea level


class Battery(MujocoSensor):
    """Charge of the battery, 1 for full; 0 stays 0, and does not stop the rotors.

    The power of a rotor is that of momentum theory, T^1.5 / sqrt(2 density area), divided by the efficiency. It is
    integrated from reading to reading.

    Attributes:
        capacity: Energy of the full battery [J].
        rotor_radius: Radius of a rotor [m].
        efficiency: Power of momentum theory per electrical power [1].
        electronics: Power of everything but the rotors [W].
        charge: Charge at the start, 0 to 1.
    """

    capacity: Joules
    rotor_radius: Metres
    efficiency: float
    electronics: Watts
    charge: float = 1.0

    def set_up(self) -> None:
        """Find the rotors in the model."""
        self._rotors = self.world.controls(self.robot, ["front", "left", "back", "right"]).ids
        self._factor = 1.0 / (self.efficiency * math.sqrt(2.0 * AIR * math.pi * self.rotor_radius**2))
        self._left, self._read_at = self.charge, self.world.stamp

    def sample(self) -> list[float]:
        """Drain the charge by the energy since the last reading, and return it."""
        world = self.world
        seconds, self._read_at = world.stamp - self._read_at, world.stamp
        if seconds > 0.0:
            thrusts = world.data.actuator_force[self._rotors].tolist()
            power = self.electronics + self._factor * sum(max(thrust, 0.0) ** 1.5 for thrust in thrusts)
            self._left = max(0.0, self._left - power * seconds / self.capacity)
        return [self._left]
