"""`rodless recover`: repair a bag whose recording was killed."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.start import Stop
from rodless_lab.bags.metadata import BagError, listed_messages
from rodless_lab.bags.writer import recover_bag


def main(arguments: Sequence[str], _stop: Stop) -> int:
    """Repair the bag in place; return 2 where that cannot be done."""
    parser = argparse.ArgumentParser(
        prog="rodless recover", description="Repair a bag whose recording was killed."
    )
    parser.add_argument("bag", type=Path, help="folder of the bag, which is repaired in place")
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
