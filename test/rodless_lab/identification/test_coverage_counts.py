# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.


"""How draws of wrong rigs are counted: by the draw, and by the parameter that is worst."""

from rodless_lab.identification.coverage import Row, Trial, silent_in_one
from rodless_lab.identification.verdict import Check, Verdict

FITS = Verdict(())
REFUSED = Verdict((Check("scatter", 300.0, 200.0, "Pa", 1e-9),))

COVERS: Row = (True, True, 0.1)
MISSES: Row = (True, False, 0.1)
OPEN: Row = (False, False, 0.1)


def test_the_worst_parameter_is_counted_where_nobody_says_so() -> None:
    """Three draws are silently wrong, none in the same parameter more than twice."""
    found = [
        Trial({"gap": MISSES, "leak": MISSES}, FITS),
        Trial({"gap": COVERS, "leak": MISSES}, FITS),
        Trial({"gap": MISSES, "leak": COVERS}, FITS),
        # Said, or left open.
        Trial({"gap": MISSES, "leak": MISSES}, REFUSED),
        Trial({"gap": COVERS, "leak": OPEN}, FITS),
    ]
    assert sum(trial.verdict.fits and not trial.covered for trial in found) == 3
    assert silent_in_one(found) == 2
    assert silent_in_one(found[3:]) == 0
    assert silent_in_one([]) == 0
