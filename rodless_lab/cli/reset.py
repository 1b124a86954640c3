# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless reset`: return a running rig to its start."""

from rodless_lab.cli.service_verb import ServiceVerb
from rodless_lab.session.reset import RESET

main = ServiceVerb(
    "reset",
    "Return the plant to its start, plant time 0, and let the controller forget the "
    "run so far, a failed control law too. The carriage holds where it is until a new set-point, "
    "or follows the step or sine that its reference is. "
    "Refused beside a controller that does not answer, such as one frozen in the last 20 s.",
    RESET,
)
