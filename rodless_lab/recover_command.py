"""`rodless recover`: make a bag that opens of one whose recording was killed."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.start import Stop
from rodless_lab.bags.metadata import BagError
from rodless_lab.bags.writer import recover_bag


def main(arguments: Sequence[str], _stop: Stop) -> int:
    """End the bag in place; return 1 where that cannot be done."""
    parser = argparse.ArgumentParser(prog="rodless recover", description=__doc__)
    parser.add_argument("bag", type=Path, help="folder of the bag; it is ended in place")
    bag = parser.parse_args(arguments).bag
    try:
        count = recover_bag(bag)
    except BagError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{count} messages in {bag}")
    return 0
