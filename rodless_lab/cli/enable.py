"""`rodless enable`: let the controller of a running rig control."""

from rodless_lab.cli.service_verb import ServiceVerb

main = ServiceVerb(
    "enable",
    "Let the controller control again after rodless disable, or after its control law has failed.",
    {"controller/enable": True},
)
