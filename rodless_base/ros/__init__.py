"""What both nodes need of ROS: topics, parameters, one process, publishers, diagnostics."""
