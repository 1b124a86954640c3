"""ament_pep257 with the settings of this package."""

from pathlib import Path

import pytest
from ament_pep257.main import main

ROOT = Path(__file__).parents[2]
PLACES = ("rodless_base", "rodless_sim", "rodless_control", "rodless_lab", "rodless_pytest")

# The summary begins beside the quotes (D213) and may name a formula (D401, D402, D403). What looks
# like a section to pydocstyle may be a sentence (D405, D407, D410, D411, D413, D414, D417).
LEFT_OUT = ("D213", "D401", "D402", "D403", "D405", "D407", "D410", "D411", "D413", "D414", "D417")


@pytest.mark.linter
@pytest.mark.pep257
def test_pep257_finds_nothing() -> None:
    """The docstrings of the product."""
    paths = [str(ROOT / place) for place in PLACES]
    assert main(["--add-ignore", *LEFT_OUT, "--", *paths]) == 0
