# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A small network as a control law, with the weights that train_law.py finds."""

from collections import deque

import numpy as np

from rodless_base.parameters import Parameter, declare
from rodless_control import Law

INPUTS, HIDDEN = 4, 4
SCALES = np.array([1e-2, 1e-3, 0.1, 1e5])  # m, m, m/s, Pa

# Where learning begins: a proportional controller that crosses the valve's flat centre.
FIRST = np.zeros((INPUTS + 1, HIDDEN))
FIRST[0, 0] = FIRST[1, 1] = FIRST[2, 2] = FIRST[3, 3] = 1.0
FIRST[4] = 2.0, 0.5, -0.5, -0.1  # V


class Learned(Law):
    """voltage = neutral + b·tanh(W x), with x: error, coarse and fine, velocity error, pressures.

    Without offsets the answer to an error and to its opposite are opposite, and no error gets none.
    """

    PARAMETERS = declare(
        Parameter("learned.weights", tuple(FIRST.ravel().tolist()), "", "W, then b in V", "learned")
    )
    DELAY = 5  # samples over which the velocity is measured

    def __init__(self, parameters=None):
        """Take the weights."""
        super().__init__(parameters)
        self._seen = deque(maxlen=self.DELAY + 1)

    def reset(self):
        """Forget the run."""
        self._seen.clear()

    def update(self, measurement, reference, interval):  # noqa: ARG002
        """Return the voltage for one sample."""
        weights = np.array(self.parameters["learned.weights"]).reshape(INPUTS + 1, HIDDEN)
        self._seen.append(measurement)
        first, elapsed = self._seen[0], measurement.time - self._seen[0].time
        velocity = (measurement.position - first.position) / elapsed if elapsed > 0.0 else 0.0
        error = reference.position - measurement.position
        difference = measurement.pressure_a - measurement.pressure_b
        inputs = np.array([error, error, velocity - reference.velocity, difference]) / SCALES
        layer = np.tanh(weights[:INPUTS].T @ inputs)
        return self.parameters["controller.neutral_voltage"] + float(weights[INPUTS] @ layer)
