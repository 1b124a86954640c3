"""Runs as arrays: read from bags, resimulated, compared, measured."""
