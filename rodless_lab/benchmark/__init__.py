"""What the kernels and the nodes cost on this machine."""
