"""Devices of robots: in the simulation, on hardware, and those that replay a recording.

Only `simulation` and `catalog` import this package; the blocks of an agent use only the interfaces `Sensor` and
`Actuator`. The small process of an isolated actuator imports it too, so it imports nothing itself.
"""
