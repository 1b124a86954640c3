"""rosbag2 bags in MCAP: recorded, read and recovered without rosbag2."""
