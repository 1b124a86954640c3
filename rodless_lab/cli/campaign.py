"""`rodless campaign`: how exactly random rigs follow their equations."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.start import Stop


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Run the rigs, print and write the tables; return 1 after Ctrl-C, 2 for a bad file."""
    parser = argparse.ArgumentParser(
        prog="rodless campaign",
        description=__doc__,
        epilog="Ctrl-C interrupts it; the same command goes on where it was. See docs/accuracy.md.",
    )
    parser.add_argument("--count", type=_positive, default=10_000, help="rigs (default 10000)")
    parser.add_argument("--output", type=Path, default=Path("results/accuracy/campaign.csv"))
    chosen = parser.parse_args(arguments)
    stop.from_now_on_wait()
    # They load numba: not for help.
    from rodless_lab.accuracy.campaign import campaign  # noqa: PLC0415
    from rodless_lab.accuracy.summary import summary  # noqa: PLC0415

    def progress(known: int) -> None:
        if known % 100 == 0 or known == chosen.count:
            print(f"{known} of {chosen.count} rigs", file=sys.stderr, flush=True)

    try:
        verdicts = campaign(chosen.output, chosen.count, progress, lambda: stop.requested)
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2
    text = summary(verdicts)
    print(text)
    chosen.output.with_suffix(".md").write_text(text, encoding="utf-8")
    if len(verdicts) < chosen.count:
        print("interrupted; the same command goes on", file=sys.stderr)
        return 1
    return 0


def _positive(text: str) -> int:
    number = int(text)
    if number <= 0:
        raise argparse.ArgumentTypeError(f"{text} refused: must be positive")
    return number
