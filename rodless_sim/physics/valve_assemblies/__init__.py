"""The ways to put the valve's equations together that ``valve.assembly`` chooses from."""
