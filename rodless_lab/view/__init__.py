# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""`rodless view`: a page in the browser that shows a rig, steers it, and plays bags.

What is shown is one state in this process (:mod:`~rodless_lab.view.state`); pages only show it. It
comes over topics (:mod:`~rodless_lab.view.ros.live`) or out of bags
(:mod:`~rodless_lab.view.playback`). What a page asks for takes the services and parameters that
everybody takes (:mod:`~rodless_lab.view.ros.desk`).
"""
