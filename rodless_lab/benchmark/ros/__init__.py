"""The part of the benchmark that runs nodes."""
