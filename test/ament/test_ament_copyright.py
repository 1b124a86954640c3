# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
