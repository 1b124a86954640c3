# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What `import rodless_lab` offers."""

import subprocess
import sys

import rodless_lab


def test_dir_shows_what_is_public() -> None:
    """Every public name is shown, can be had and describes itself; others are refused by name."""
    assert dir(rodless_lab) == sorted(rodless_lab.__all__)
    assert {"closed_loop", "read_bag", "read_run"} <= set(dir(rodless_lab))
    for name in rodless_lab.__all__:
        assert getattr(rodless_lab, name).__doc__
    assert not hasattr(rodless_lab, "read_bags")


def test_importing_it_loads_next_to_nothing() -> None:
    """Neither numba nor rclpy: each public object loads its own module."""
    script = "import sys, rodless_lab; print({'numba', 'rclpy', 'numpy'} & set(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True
    )
    assert run.stdout.strip() == "set()"
