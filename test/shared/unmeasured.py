"""The environment for processes whose lines are not measured for coverage."""

import os


def unmeasured() -> dict[str, str]:
    """Return this process's environment without what makes coverage measure its children."""
    return {name: value for name, value in os.environ.items() if not name.startswith("COV")}
