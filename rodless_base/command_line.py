# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What every verb reads its command line with: a refusal is one line, with the way to the help."""

import argparse
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn, TypeVar

from rodless_base.file_path import file_path
from rodless_base.one_line import in_one_line

Given = TypeVar("Given", bound=str | None)


class Parser(argparse.ArgumentParser):
    """Python's parser, without the summary of all options that it prints before its refusals."""

    def parse_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> argparse.Namespace:
        """Return the options; end the program for arguments that are none, an empty one too."""
        found, others = self.parse_known_args(args, namespace)
        if others:
            self.error(f"unrecognized arguments: {shlex.join(others)}")
        return found

    def error(self, message: str) -> NoReturn:
        """End the program with a line on standard error."""
        self.exit(2, f"{self.prog}: error: {in_one_line(message)}; see {self.prog} --help\n")


def once_each(parser: Parser, changes: Sequence[tuple[str, Given]]) -> dict[str, Given]:
    """Return ``changes`` by name; end the program where two have one name."""
    given: dict[str, Given] = {}
    for name, value in changes:
        if name in given:
            values = [text for text in (given[name], value) if text is not None]
            as_what = f", as {' and '.join(values)}" if values else ""
            parser.error(f"{name}: refused, given twice{as_what}")
        given[name] = value
    return given


def named_path(text: str) -> Path:
    """Return the path that an argument names; raises ArgumentTypeError for what names none."""
    return file_path(text, argparse.ArgumentTypeError)
