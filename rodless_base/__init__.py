"""What the plant and the controller both stand on: parameters, compiled kernels, ROS process."""
