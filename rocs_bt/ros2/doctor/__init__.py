"""Which topics of a robot are on the network, at which rate, and whether they match: `rocs-bt doctor --ros2`."""
