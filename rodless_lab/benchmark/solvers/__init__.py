"""What the benchmark compares: this package, the same in C, and other people's solvers."""
