"""When a rig that has been started is ready, and what its user can do then."""

from collections.abc import Callable
from time import monotonic

from diagnostic_msgs.msg import DiagnosticStatus

from rodless_base.ros.topics import JOINT_STATES, VALVE_VOLTAGE
from rodless_lab.session.observer import Diagnostic, Observer
from rodless_lab.session.running_rig import CONTROLLER, PLANT

# Wall-clock s after which a rig whose nodes have reported, but do not work, says why.
REPORT_SECONDS = 10.0


def say_when_ready(
    what: str,
    namespace: str,
    with_controller: bool,
    ended: Callable[[], bool],
    say: Callable[[str], None],
) -> None:
    """Call ``say`` with a line as soon as the nodes report that they work, or ``ended()``.

    ``what`` names the rig in it. A plant without a controller is ready once it reports.
    """
    wanted = [PLANT, CONTROLLER] if with_controller else [PLANT]
    namespace = f"/{namespace.strip('/')}"
    with Observer(namespace=namespace) as observer:
        names = [observer.node.resolve_topic_name(node) for node in wanted]
        said = observer.diagnostics
        reported: float | None = None
        warned = False
        while not ended():
            observer.spin()
            if not all(name in said for name in names):
                continue
            failing = {name: said[name] for name in names if _is_error(said[name])}
            if not failing or not with_controller:
                say(_line(what, observer, namespace, with_controller, said[names[0]]))
                return
            reported = reported or monotonic()
            if not warned and monotonic() > reported + REPORT_SECONDS:
                warned = True
                say("not ready: " + "; ".join(f"{n}: {d.message}" for n, d in failing.items()))


def _is_error(said: Diagnostic) -> bool:
    return bool(said.level == DiagnosticStatus.ERROR)


def _line(
    what: str, observer: Observer, namespace: str, with_controller: bool, plant: Diagnostic
) -> str:
    lockstep = plant.values.get("mode") == "lockstep"
    option = "" if namespace == "/" else f" --namespace {namespace}"
    resolved = observer.node.resolve_topic_name
    if with_controller:
        first = f"move the carriage: rodless move 58{option}"
    elif lockstep:
        first = (
            f"waiting for a subscriber to {resolved(JOINT_STATES)} and one publisher on "
            f"{resolved(VALVE_VOLTAGE)}"
        )
    else:
        first = f"commands are expected on {resolved(VALVE_VOLTAGE)}"
    mode = "lock-step" if lockstep else "real time"
    return f"ready: {what}, {mode}; {first}; look: rodless status{option}; stop: Ctrl-C"
