"""MCAP, the storage format of rosbag2 bags."""
