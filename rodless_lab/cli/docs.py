"""`rodless docs`: write what the docs show of the code itself."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from rodless_base.start import Stop
from rodless_lab.reports.docs import write_docs


def main(arguments: Sequence[str], stop: Stop) -> int:  # noqa: ARG001
    """Write the pages into a folder."""
    parser = argparse.ArgumentParser(prog="rodless docs", description=__doc__)
    parser.add_argument("folder", type=Path, help="where the docs are")
    write_docs(parser.parse_args(arguments).folder, lambda name: print(name, flush=True))
    return 0
