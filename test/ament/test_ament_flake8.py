# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

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
