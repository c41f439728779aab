"""What the blocks of an agent share: devices, the safety gate, channels, actions, their pipeline, and ROS 2."""
