"""What the tests of the harness share."""

from collections.abc import Callable
from pathlib import Path

from rodless_lab.harness import RigSession

ROOT = Path(__file__).resolve().parents[2]

# What the fixture ``rig_session`` returns.
StartRig = Callable[..., RigSession]

# For a process of a test to end, in wall-clock seconds.
TIMEOUT = 500.0
