# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A law in Python is asked for a command."""

from rodless_base.measurement import Measurement
from rodless_base.one_line import traced
from rodless_control import ReferencePoint
from rodless_control.controller import Law, LawError, checked_answer, law_name


class LawFailedError(LawError):
    """A law has raised; the text names time, law and line, ``raised`` is what it was."""

    def __init__(self, text: str, raised: BaseException) -> None:
        """Keep what the law has raised."""
        super().__init__(text)
        self.raised = raised


def ask(
    law: Law, measurement: Measurement, reference: ReferencePoint, interval: float
) -> tuple[float, ...]:
    """Return voltage (V) and terms.

    Raises LawError with the time where they are none, and LawFailedError where the law raises.
    """
    try:
        return checked_answer(law, law.update(measurement, reference, interval))
    except LawError as error:
        raise LawError(f"at {measurement.time:g} s: {error}") from error
    except (Exception, SystemExit) as error:
        text = f"at {measurement.time:g} s: {law_name(law)} failed: {traced(error)}"
        raise LawFailedError(text, error) from error
