# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The interface of control laws: what each receives at a sample and returns.

A :class:`Law` is plain Python. A :class:`CompiledLaw` is made of pure compiled functions, which run
in one loop with the rig. Both serve ``rodless_lab.closed_loop`` and the controller node alike.
"""

import hashlib
import inspect
import math
import re
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from rodless_base.kernels import is_kernel, same_type, specialise
from rodless_base.measurement import Measurement
from rodless_base.one_line import described, function_name, in_one_line, shown
from rodless_base.parameter_file import is_of_rclpy
from rodless_base.parameters import Parameter, ParameterError, ParameterSet
from rodless_base.real_number import is_number
from rodless_control.parameters import NODE_PARAMETERS, OUTPUT, REFERENCE, LawParameters


class ReferencePoint(NamedTuple):
    """Where the carriage should be, and how fast it should move there.

    Examples
    --------
    >>> ReferencePoint(0.058)
    ReferencePoint(position=0.058, velocity=0.0)
    """

    position: float  # m
    velocity: float = 0.0  # m/s


# A voltage in V, or a NamedTuple of the field ``voltage`` and the law's ``TERMS``.
Answer = float | tuple[float, ...]


class LawError(ValueError):
    """A law has answered with something that is no command; the text names law and answer."""


def _file_digest(module: str) -> str:
    """Return a digest of the file of a module that is being imported; empty without one."""
    file = getattr(sys.modules.get(module), "__file__", None)
    with suppress(OSError):  # in an archive
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()[:16] if file else ""
    return ""


class Law:
    """A control law; subclass it and write :meth:`update`.

    ``PARAMETERS`` declares the law's own parameters. In the controller node they are ROS
    parameters; what a preset or file gives reaches them by their names. ``parameters`` holds the
    values in force: those, and the limits of the output ``controller.minimum_voltage``,
    ``.neutral_voltage`` and ``.maximum_voltage`` (V).

    ``TERMS`` names what :meth:`update` returns besides the voltage; each is a topic of the node
    below ``~/``. ``USES_PRESSURES`` says whether the law reads pressures; without them the node
    answers positions alone.

    Examples
    --------
    A proportional law with a parameter of its own:

    >>> from rodless_base.parameters import Parameter, declare
    >>> class Proportional(Law):
    ...     PARAMETERS = declare(
    ...         Parameter("mine.gain", 200.0, "V/m", "proportional gain", "tuned", 0.0, 1e4)
    ...     )
    ...
    ...     def update(self, measurement, reference, interval):
    ...         error = reference.position - measurement.position
    ...         return 5.08 + self.parameters["mine.gain"] * error
    >>> law = Proportional({"mine.gain": 100.0})
    >>> round(law.update(Measurement(0, 0.05), ReferencePoint(0.06), 0.0), 6)
    6.08
    """

    PARAMETERS: ClassVar[dict[str, Parameter]] = {}
    TERMS: ClassVar[tuple[str, ...]] = ()
    USES_PRESSURES: ClassVar[bool] = True

    # The set of this law's parameters; made from PARAMETERS where a law does not bring its own.
    Parameters: ClassVar[type[LawParameters]] = LawParameters

    # Of the file as it was when this class was made of it: an edit since then is not what runs.
    SOURCE_DIGEST: ClassVar[str] = ""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.SOURCE_DIGEST = _file_digest(cls.__module__)
        if "Parameters" in vars(cls):
            return
        name = cls.__name__
        content: dict[str, object] = {
            "__doc__": f"The parameters of the law {name}.",
            "__module__": cls.__module__,
            # Where pickle finds it.
            "__qualname__": f"{cls.__qualname__}.Parameters",
            "NAMED_BY": f"{name}.Parameters",
            "LAW_NAME": f"{cls.__module__}:{cls.__qualname__}",
        }
        if "PARAMETERS" in vars(cls):
            own = checked_declarations(cls)
            content["DECLARATIONS"] = {**own, **OUTPUT}
            cls.Parameters = type(f"{name}Parameters", (LawParameters,), content)
        else:
            # Those of the base class, for this law.
            cls.Parameters = type(f"{name}Parameters", (cls.Parameters,), content)

    def __init__(self, parameters: Mapping[str, object] | None = None) -> None:
        """Take values by name (default: all defaults); raises ParameterError."""
        given = parameters if isinstance(parameters, ParameterSet) else None
        if given is not None:
            self._refuse_parameters_of_others(given)
        self.parameters: ParameterSet = given or self.Parameters(parameters)

    def __repr__(self) -> str:
        """Show the call that makes a law like this; what it remembers is left out."""
        return f"{type(self).__name__}({self.parameters!r})"

    def _refuse_parameters_of_others(self, given: ParameterSet) -> None:
        missing = self.Parameters.DECLARATIONS.keys() - given.keys()
        if missing:
            wanted = self.Parameters.NAMED_BY or self.Parameters.__name__
            raise ParameterError(
                f"{type(self).__name__}: {in_one_line(repr(given))} refused, it has no "
                f"{min(missing)}; give {wanted}(...) or values by name"
            )

    def configure(self, parameters: ParameterSet) -> None:
        """Take other parameters while running, where possible without a jump of the command.

        Called between two samples with a whole, valid set, which may leave everything as it was.
        In the node, the new set is in force even if this raises: the valve closes until
        ``~/reset`` or ``~/enable``, which make the law anew with that set.
        """
        self.parameters = parameters

    def reset(self) -> None:
        """Forget the run so far.

        Called before the first sample of each run: once the law is made, by ``~/reset`` and
        ``~/enable``, and when the stamps of the samples run backwards. If this raises,
        :meth:`update` is not called: the valve closes as for :meth:`configure`.
        """

    def hold(self) -> None:
        """Called when measurements were missing: the next sample follows a gap.

        The node calls it once positions have stopped for ``controller.position_timeout``, and for
        each sample with a value that is not finite; ``closed_loop`` does that too. If this raises,
        the valve closes as for :meth:`configure`.
        """

    def update(
        self, measurement: Measurement, reference: ReferencePoint, interval: float
    ) -> Answer:
        """Answer one sample.

        Parameters
        ----------
        measurement
            What the instruments read: ns, m, Pa.
        reference
            Where the carriage should be at that time.
        interval
            Time since the sample before in s; 0 for the first.

        Returns
        -------
        float or NamedTuple
            The voltage in V, finite; or a NamedTuple of the field ``voltage`` and one for each of
            ``TERMS``.
        """
        raise NotImplementedError(f"{type(self).__name__} has no update()")


class FunctionLaw(Law):
    """A function of measurement and reference that returns a voltage in V."""

    Parameters = LawParameters

    def __init__(self, function: Callable[[Measurement, ReferencePoint], float]) -> None:
        """Take the function; raises TypeError for one that does not take two arguments."""
        super().__init__()
        try:
            inspect.signature(function).bind(None, None)
        except TypeError as error:
            raise TypeError(
                f"{shown(function)} is no control law, {error}: give a function "
                "(measurement, reference) -> voltage in V"
            ) from error
        except ValueError:  # one of C that does not say what it takes
            pass
        self.function = function

    def __repr__(self) -> str:
        """Show the function."""
        return f"FunctionLaw({shown(self.function)})"

    def update(
        self,
        measurement: Measurement,
        reference: ReferencePoint,
        interval: float,  # noqa: ARG002
    ) -> Answer:
        """Call the function."""
        return self.function(measurement, reference)


class Kernels(NamedTuple):
    """The pure functions of a compiled law.

    ``gains``, ``memory`` and ``command`` are NamedTuples of the law's own; all fields of the
    command are floats, the first is ``voltage``, the others are the law's ``TERMS``. ``begin`` and
    ``update`` are compiled with ``rodless_base.kernels.kernel``.
    """

    gains_of: Callable[[ParameterSet], Any]  # (parameters) -> gains
    begin: Callable[..., Any]  # (gains, measurement) -> memory
    update: Callable[..., Any]  # (gains, memory, measurement, reference, interval)


class CompiledLaw(Law):
    """A law made of compiled functions: ``KERNELS``, and what else a :class:`Law` may state.

    Examples
    --------
    >>> from rodless_control import Pid
    >>> Pid.KERNELS.begin(Pid().gains, Measurement(0, 0.05)).filtered_position
    0.05
    """

    KERNELS: ClassVar[Kernels]
    Parameters = LawParameters

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if not hasattr(cls, "KERNELS"):
            raise TypeError(f"{cls.__name__}: KERNELS is missing")
        for name in ("begin", "update"):
            if not is_kernel(getattr(cls.KERNELS, name)):
                raise TypeError(
                    f"{cls.__name__}: KERNELS.{name} is not compiled; decorate it with "
                    "rodless_base.kernels.kernel"
                )

    def __init__(self, parameters: Mapping[str, object] | None = None) -> None:
        """Take values by name (default: all defaults) and compile.

        Raises ParameterError, and TypeError where ``TERMS`` are not the command's.
        """
        if not hasattr(type(self), "KERNELS"):
            raise TypeError(f"{type(self).__name__} has no KERNELS: give a subclass of it")
        super().__init__(parameters)
        checked_terms(type(self))
        self.gains = self.KERNELS.gains_of(self.parameters)
        self._compile()
        self.memory: Any = None
        self._held = False

    def _compile(self) -> None:
        example = Measurement(0, 0.0)
        self._begin = self._specialised("begin", self.gains, example)
        begun = self._begin(self.gains, example)
        first_sample = (self.gains, begun, example, ReferencePoint(example.position), 0.0)
        self._update = self._specialised("update", *first_sample)
        answer = self._update(*first_sample)
        if not (isinstance(answer, tuple) and len(answer) == 2):
            raise TypeError(
                f"{type(self).__name__}: KERNELS.update returns {shown(answer)}, but must return "
                "memory and command"
            )
        memory, command = answer
        if not same_type(memory, begun):
            raise TypeError(
                f"{type(self).__name__}: the memory of KERNELS.update, {shown(memory)}, has other "
                f"types than that of KERNELS.begin, {shown(begun)}; write 0.0 for a real zero"
            )
        self._check_terms(command)

    def _specialised(self, name: str, *example: object) -> Any:
        """Return a kernel compiled for these; raises TypeError in one line where it does not."""
        try:
            return specialise(getattr(self.KERNELS, name), *example)
        except TypeError as error:
            raise TypeError(f"{type(self).__name__}: KERNELS.{name} {described(error)}") from error

    def __getstate__(self) -> dict[str, object]:
        """Leave the compiled functions out: :mod:`pickle` and :mod:`copy` cannot have them."""
        return {n: v for n, v in vars(self).items() if n not in ("_begin", "_update")}

    def __setstate__(self, state: dict[str, object]) -> None:
        """Compile again."""
        vars(self).update(state)
        self._compile()

    def _check_terms(self, command: object) -> None:
        fields = getattr(command, "_fields", None)
        # A subclass that updates in Python may answer with more than its kernel does.
        if type(self).update is CompiledLaw.update and fields != ("voltage", *self.TERMS):
            has = f"has the fields {', '.join(fields)}" if fields else "is no NamedTuple"
            wanted = ", ".join(("voltage", *self.TERMS))
            raise TypeError(
                f"{type(self).__name__}: the command of KERNELS.update {has}, but must have "
                f"voltage and TERMS: {wanted}"
            )
        for name, value in zip(fields or (), command, strict=True):  # type: ignore[call-overload]
            if type(value) is not float:
                raise TypeError(
                    f"{type(self).__name__}: {name} in the command of KERNELS.update is "
                    f"{shown(value)}, but must be a float; write 0.0 for 0"
                )

    def configure(self, parameters: ParameterSet) -> None:
        """Change the parameters; :meth:`retuned` says what becomes of the memory."""
        super().configure(parameters)
        old, self.gains = self.gains, self.KERNELS.gains_of(parameters)
        if self.memory is not None:
            self.memory = self.retuned(old, self.memory)

    def reset(self) -> None:
        """Forget everything; the next sample is taken as the first."""
        self.memory = None
        self._held = False

    def hold(self) -> None:
        """Begin anew with the next sample, with what :meth:`resumed` keeps of the memory."""
        self._held = True

    def update(self, measurement: Measurement, reference: ReferencePoint, interval: float) -> Any:
        """Evaluate the law; see :meth:`Law.update`.

        A sample that it answers with no finite voltage, such as one whose position is NaN, leaves
        no trace in the memory. Raises ValueError for an ``interval`` that is negative
        or not finite.
        """
        if not 0.0 <= interval < math.inf:
            raise ValueError(
                f"interval {shown(interval)} s refused: must be the time since the sample before, "
                "0 or more"
            )
        if self.memory is None or self._held:
            begun, interval = self._begin(self.gains, measurement), 0.0
            memory = begun if self.memory is None else self.resumed(begun, self.memory)
        else:
            memory = self.memory
        after, command = self._update(self.gains, memory, measurement, reference, interval)
        if math.isfinite(command[0]):
            self.memory, self._held = after, False
        return command

    def resumed(self, begun: Any, before: Any) -> Any:  # noqa: ARG002
        """Return the memory after a gap: ``begun``, with what should survive of ``before``."""
        return begun

    def retuned(self, old: Any, memory: Any) -> Any:  # noqa: ARG002
        """Return the memory with which ``self.gains`` go on where the ``old`` gains were."""
        return memory


# What ROS takes for a name of a parameter, and for the last part of a topic's.
PARAMETER_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*")
TERM_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

# Names that a law cannot have, besides those that rclpy gives each node: the controller's own.
TAKEN = {*OUTPUT, *NODE_PARAMETERS, *REFERENCE}


def checked_declarations(law: type[Law]) -> dict[str, Parameter]:
    """Return the ``PARAMETERS`` of a law; raises TypeError for what cannot be parameters."""
    declared = law.PARAMETERS
    if not isinstance(declared, dict):
        raise TypeError(
            f"{law.__name__}: PARAMETERS {shown(declared)} refused, must be declare(Parameter(...))"
        )
    for name, parameter in declared.items():
        if not isinstance(parameter, Parameter) or parameter.name != name:
            raise TypeError(
                f"{law.__name__}: PARAMETERS[{shown(name)}] refused, must be a Parameter of that "
                "name; use declare(Parameter(...))"
            )
        if not isinstance(name, str) or not PARAMETER_NAME.fullmatch(name):
            raise TypeError(
                f"{law.__name__}: the parameter name {shown(name)} refused, must be letters, "
                'digits and _, with dots between parts, such as "mine.gain"'
            )
        if name in TAKEN or is_of_rclpy(name):
            raise TypeError(
                f"{law.__name__}: its parameter {name} is the node's own; choose another name"
            )
    return declared


def checked_terms(law: type[Law]) -> tuple[str, ...]:
    """Return the ``TERMS`` of a law; raises TypeError for what cannot be topics and columns."""
    terms = law.TERMS
    sound = isinstance(terms, tuple | list) and all(
        isinstance(term, str) and TERM_NAME.fullmatch(term) for term in terms
    )
    if not sound or len({"reference", "voltage", *terms}) < len(terms) + 2:
        raise TypeError(
            f"{law.__name__}: its TERMS {shown(terms)} must be identifiers, each once, in a tuple, "
            "and none of them reference or voltage"
        )
    return tuple(terms)


def checked_answer(law: Law, answer: object) -> tuple[float, ...]:
    """Return voltage (V) and terms of an answer; raises LawError for what is no command."""
    values = answer if isinstance(answer, tuple) else (answer,)
    wanted = ("voltage", *law.TERMS)
    if len(values) != len(wanted) or getattr(answer, "_fields", wanted) != wanted:
        raise LawError(f"{law_name(law)} answered {shown(answer)}: must be {' and '.join(wanted)}")
    numbers = values
    if set(map(type, values)) != {float}:
        if not all(map(is_number, values)):
            wanted_kind = "numbers" if law.TERMS else "a number in V"
            raise LawError(f"{law_name(law)} answered {shown(answer)}: must be {wanted_kind}")
        try:
            numbers = tuple(map(float, values))
        except OverflowError as error:  # a whole number too large for a float
            raise LawError(
                f"{law_name(law)} answered {shown(answer)}: must be finite numbers"
                if law.TERMS
                else f"{law_name(law)} answered {shown(answer)} V: must be a finite number"
            ) from error
    if not math.isfinite(numbers[0]):
        raise LawError(f"{law_name(law)} answered {numbers[0]!r} V: must be a finite number")
    return numbers


def law_name(law: Law) -> str:
    """Return what messages call the law."""
    if isinstance(law, FunctionLaw):
        return f"law {function_name(law.function)}"
    return f"law {type(law).__name__}"


def checked_base(law: Law) -> Law:
    """Return a law whose base class was set up; raises TypeError for one without."""
    if not hasattr(law, "parameters"):
        raise TypeError(f"{law_name(law)}: __init__ must call super().__init__()")
    return law


def output_limits(parameters: ParameterSet) -> tuple[float, float]:
    """Return the lowest and the highest command in V."""
    return (
        parameters.number("controller.minimum_voltage"),
        parameters.number("controller.maximum_voltage"),
    )
