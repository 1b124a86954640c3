# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless view`: a page in the browser that shows a rig, steers it, and plays bags."""

import argparse
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path

from rodless_base.command_line import Parser, named_path
from rodless_base.extras import missing_extra
from rodless_base.parameter_file import preset_names
from rodless_base.start import Stop
from rodless_lab.cli.number import number
from rodless_lab.cli.running_rig import NOT_POSSIBLE, add_namespace
from rodless_lab.session.errors import HarnessError, InterruptedRunError, NodeDiedError

HOST, PORT, PRESET = "127.0.0.1", 8080, "paper"


def main(arguments: Sequence[str], stop: Stop) -> int:
    """Serve until ``stop``; return 1 where its own rig ends by itself, 2 for what cannot be."""
    options = _options(arguments)
    if importlib.util.find_spec("nicegui") is None:
        print(missing_extra("rodless view", "nicegui", "view"), file=sys.stderr)
        return NOT_POSSIBLE
    # Here, so that help is quick and works without ROS.
    from rodless_lab.view.app import Options, serve  # noqa: PLC0415
    from rodless_lab.view.errors import ViewError  # noqa: PLC0415

    stop.from_now_on_wait()
    try:
        serve(Options(**vars(options)), stop, lambda line: print(line, flush=True))
    except InterruptedRunError:
        return 0
    except NodeDiedError as error:
        print(error, file=sys.stderr)
        return 1
    except (HarnessError, ViewError) as error:
        print(error, file=sys.stderr)
        return NOT_POSSIBLE
    return 0


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = Parser(
        prog="rodless view",
        description="Show a rig in the browser, steer it, record it and play bags. Joins the rig "
        "that runs in the namespace, or starts one with --rig; with BAG it shows bags alone.",
        epilog="Exit code: 0 Ctrl-C; 1 a rig of its own has ended; 2 it cannot be shown.",
    )
    parser.add_argument(
        "bags", nargs="*", type=named_path, metavar="BAG", help="one, or two to compare"
    )
    add_namespace(parser)
    parser.add_argument("--rig", action="store_true", help="start a rig, which ends with the view")
    parser.add_argument("--preset", choices=preset_names(), help=f"of --rig (default: {PRESET})")
    parser.add_argument(
        "--host", default=HOST, help="address to listen on (default: %(default)s, this machine)"
    )
    parser.add_argument(
        "--port", type=port, default=PORT, help="0 for a free one (default: %(default)s)"
    )
    parser.add_argument(
        "--folder",
        type=named_path,
        default=Path(),
        help="of the bags to record and open (default: here)",
    )
    options = parser.parse_args(arguments)
    if options.preset is not None and not options.rig:
        parser.error("--preset is of --rig; add --rig")
    options.preset = options.preset or PRESET
    return options


def port(text: str) -> int:
    """Return a port; argparse shows this function's name where ``text`` is no number."""
    value = number(text)
    if not 0 <= value <= 65535 or value != int(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a port from 0 to 65535")
    return int(value)
