"""ament_copyright: each file says whose it is and under which licence."""

from pathlib import Path

import pytest
from ament_copyright.main import main

ROOT = Path(__file__).parents[2]
PLACES = (
    *("rodless_base", "rodless_sim", "rodless_control", "rodless_lab", "rodless_pytest"),
    *("test", "launch", "templates", "setup.py", "LICENSE", "CONTRIBUTING.md"),
)


@pytest.mark.copyright
@pytest.mark.linter
def test_every_file_has_the_header_of_the_licence() -> None:
    """As `make headers` writes it."""
    assert main([str(ROOT / place) for place in PLACES]) == 0
