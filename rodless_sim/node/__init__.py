"""The plant as a ROS node."""
