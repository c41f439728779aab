"""A package beside rocs_bt: a command, a driver and a node, found by their entry points."""
