"""`rodless reset`: return a running rig to its start."""

from rodless_lab.cli.service_verb import ServiceVerb

main = ServiceVerb(
    "reset",
    "Return the plant to its start, plant time 0, and let the controller forget the "
    "run so far, a failed control law too. The carriage holds where it is until a new set-point.",
    {"plant/reset": None, "controller/reset": None},
)
