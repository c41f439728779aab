"""The ROS 2 network: raw messages by rclpy or by DDS, quality of service, services, servers and clock."""
