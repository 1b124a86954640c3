"""The paper's experiments: each a small function from parameters to a frozen result."""
