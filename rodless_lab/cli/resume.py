"""`rodless resume`: let the plant time of a running rig run on."""

from rodless_lab.cli.service_verb import ServiceVerb

main = ServiceVerb(
    "resume",
    "Let plant time run on after rodless pause.",
    {"plant/pause": False},
)
