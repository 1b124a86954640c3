# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What is said where the library mcap is not installed."""

import subprocess
import sys

TIMEOUT = 60.0  # s

WITHOUT_MCAP = """
import importlib, sys

class WithoutMcap:
    def __init__(self, finder):
        self.finder = finder

    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "mcap":
            return None
        return self.finder.find_spec(name, path, target)

sys.meta_path[:] = map(WithoutMcap, sys.meta_path)
for module in sys.argv[1:]:
    try:
        importlib.import_module("rodless_lab.bags." + module)
    except ModuleNotFoundError as error:
        print(error.name, error)
"""


def test_every_way_to_a_bag_says_how_to_get_mcap() -> None:
    """Reading, listing and writing alike, whichever is imported first, each in one line."""
    modules = ["recorded_topics", "reader", "storage", "writer", "mcap_file.index"]
    run = subprocess.run(
        [sys.executable, "-c", WITHOUT_MCAP, *modules],
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=True,
    )
    line = "mcap bags need the library mcap: pip install mcap"
    assert run.stdout.splitlines() == [line] * len(modules)
