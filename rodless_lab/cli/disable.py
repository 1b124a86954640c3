"""`rodless disable`: close the valve of a running rig and keep it closed."""

from rodless_lab.cli.service_verb import ServiceVerb

main = ServiceVerb(
    "disable",
    "Switch the controller off: it commands a closed valve until rodless enable.",
    {"controller/enable": False},
)
