"""Chambers and valve from the pressures of a run."""
