"""Bags of the rig's topics."""

from collections.abc import Callable
from pathlib import Path

import pytest
import rig_bag


@pytest.fixture
def write_bag() -> Callable[..., Path]:
    """The function that writes a run as a bag."""
    return rig_bag.write
