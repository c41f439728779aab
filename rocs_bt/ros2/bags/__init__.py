"""ROS 2 bags: runs exported as bags, and agents that run again on recorded topics."""
