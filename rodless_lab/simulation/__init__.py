"""Rig and control law without ROS."""
