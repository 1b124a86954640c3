# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless docs`: write what the docs show of the code itself."""

from collections.abc import Sequence

from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.cli.exit_code import exit_code
from rodless_lab.reports.docs import write_docs


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Write the pages into a folder; return 2 where it cannot be written."""
    parser = Parser(prog="rodless docs", description=__doc__)
    parser.add_argument("folder", type=named_path, help="where the docs are")
    folder = parser.parse_args(arguments).folder
    return exit_code(lambda: write_docs(folder, lambda name: print(name, flush=True)), folder)
