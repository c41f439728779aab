"""Message types of ROS 2: their fields, short forms, frames and names."""
