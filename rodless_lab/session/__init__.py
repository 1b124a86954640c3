"""Starting, watching and disturbing nodes: what harness, demo, benchmark and tests stand on."""
