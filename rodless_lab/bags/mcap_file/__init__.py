"""MCAP, the storage format of rosbag2 bags."""

from importlib.util import find_spec

if find_spec("mcap") is None:  # installed from the ROS build farm, which has no package of it
    raise ModuleNotFoundError("bags need the library mcap: pip install mcap", name="mcap")
