# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The linters of ROS run where ROS has them; elsewhere `make lint` says the same, and more."""

from importlib.util import find_spec

LINTERS = ("ament_copyright", "ament_flake8", "ament_pep257")

collect_ignore = [f"test_{linter}.py" for linter in LINTERS if find_spec(linter) is None]
