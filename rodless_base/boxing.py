# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What compiled code returns is made in C alone.

numba makes named tuples and arrays by running Python: their classes are unpickled, and the named
tuple's is called. Ctrl-C that has come while compiled code ran is raised there, in the midst of
what does not look for it, and the interpreter crashes. Without Python in between it is raised once
the result is there.
"""

from functools import cache
from typing import Any

from numba import types
from numba.core import pythonapi, serialize
from numba.core.boxing import box_tuple

# A cache that is itself in C: only the first of each class is unpickled by running Python.
serialize._numba_unpickle = cache(serialize._numba_unpickle)

# By type: how compiled code hands its values to Python. numba has no public way to replace one.
_BOXERS = pythonapi._boxers.functions

_BY_NUMBA = {kind: _BOXERS[kind] for kind in (types.NamedTuple, types.NamedUniTuple)}


def _is_plain(cls: type) -> bool:
    """Whether making an instance is no more than making a tuple: nobody wrote a ``__new__``."""
    return str(getattr(cls.__new__, "__module__", "")).startswith("namedtuple_")


def _box_named_tuple(typ: Any, value: Any, context: Any) -> Any:
    """Return the code that makes a Python object of a value."""
    cls, environment = typ.instance_class, context.env_manager
    if environment is None or not _is_plain(cls):
        return _BY_NUMBA[type(typ)](typ, value, context)
    make, kind = (
        environment.read_const(environment.add_const(one)) for one in (tuple.__new__, cls)
    )
    items = box_tuple(typ, value, context)
    found = context.pyapi.call_function_objargs(make, (kind, items))
    context.pyapi.decref(items)
    return found


_BOXERS.update(dict.fromkeys(_BY_NUMBA, _box_named_tuple))
