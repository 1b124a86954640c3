"""Recording topics of running nodes into a bag."""
