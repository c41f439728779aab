"""Behaviour-tree nodes with Nav2's names, ports and outcomes, implemented with the robot's planners and actions."""
