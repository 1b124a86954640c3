"""The linters of ROS run where ROS has them; elsewhere `make lint` says the same, and more."""

from importlib.util import find_spec

LINTERS = ("ament_copyright", "ament_flake8", "ament_pep257")

collect_ignore = [f"test_{linter}.py" for linter in LINTERS if find_spec(linter) is None]
