"""The linters of ROS run where ROS has them; elsewhere `make lint` says the same, and more."""

from importlib.util import find_spec
from pathlib import Path

LINTERS = ("ament_copyright", "ament_flake8", "ament_pep257")

collect_ignore = [f"test_{linter}.py" for linter in LINTERS if find_spec(linter) is None]

# Until package.xml names a maintainer, a header has nobody to name. `make release-check` asks for
# both.
if ".example" in (Path(__file__).parents[2] / "package.xml").read_text(encoding="utf-8"):
    collect_ignore.append("test_ament_copyright.py")
