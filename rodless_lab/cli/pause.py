"""`rodless pause`: stop the plant time of a running rig."""

from rodless_lab.cli.service_verb import ServiceVerb

main = ServiceVerb(
    "pause",
    "Stop plant time: the rig stays as it is until rodless resume.",
    {"plant/pause": True},
)
