"""ament_flake8 with the settings of this package."""

from pathlib import Path

import pytest
from ament_flake8.main import main_with_errors

ROOT = Path(__file__).parents[2]
PLACES = ("rodless_*", "test", "launch", "templates", "setup.py")


@pytest.mark.flake8
@pytest.mark.linter
def test_flake8_finds_nothing() -> None:
    """100 columns, double quotes; the file says what else."""
    paths = [str(path) for place in PLACES for path in ROOT.glob(place)]
    code, errors = main_with_errors(["--config", str(ROOT / "ament_flake8.ini"), *paths])
    assert code == 0, "\n".join(errors)
