"""Robots with ROS 2: sensors read topics, actuators publish commands (paper, section 7 and Figure 10).

`network` carries raw messages, by rclpy where ROS 2 is installed, else by DDS without ROS. Topics, message types and
quality of service are keys of robot.toml. Nothing of ROS is imported before a connection is opened.
"""
