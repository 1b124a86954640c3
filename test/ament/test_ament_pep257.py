# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
