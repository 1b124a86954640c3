"""Long runs: whether the nodes stay as they are, lose nothing and keep their balance."""
