"""The robots of a scenario simulated as ROS 2 robots: `rocs-bt sim`."""
