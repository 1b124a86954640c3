"""Where values come from, as the declarations cite it."""

PAPER = "Zhang et al. 2022"
JUDGEMENT = "judgement"
