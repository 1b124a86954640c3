# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless recover`: repair a bag whose recording was killed."""

import sys
from collections.abc import Sequence

from rodless_base.command_line import Parser, named_path
from rodless_base.start import Stop
from rodless_lab.bags.metadata import BagError, listed_messages
from rodless_lab.bags.writer import recover_bag


def main(arguments: Sequence[str], _stop: Stop) -> int:
    """Repair the bag in place; return 2 where that cannot be done."""
    parser = Parser(prog="rodless recover", description="Repair a bag whose recording was killed.")
    parser.add_argument(
        "bag", type=named_path, help="folder of the bag, which is repaired in place"
    )
    bag = parser.parse_args(arguments).bag
    try:
        listed = listed_messages(bag)
        count = recover_bag(bag)
    except BagError as error:
        print(error, file=sys.stderr)
        return 2
    lost = "" if listed in (None, count) else f", of {listed} once recorded"
    print(f"{count} messages in {bag}{lost}")
    return 0
