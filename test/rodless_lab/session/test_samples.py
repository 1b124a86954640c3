# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A session's samples against what they are named after."""

from dataclasses import fields

from rodless_control import Pid
from rodless_lab.session.samples import TERMS, Sample, Samples


def test_telemetry_has_the_terms_of_the_pid() -> None:
    """The session names the PID's terms as the law itself does, the reference first."""
    assert ("reference", *Pid.TERMS) == TERMS


def test_a_run_has_a_column_for_each_part_of_a_sample_and_each_term() -> None:
    """Samples are the fields of one sample, the voltage, and the terms, in this order."""
    names = (*Sample._fields, "voltage", *TERMS, "terms")
    assert tuple(field.name for field in fields(Samples)) == names
