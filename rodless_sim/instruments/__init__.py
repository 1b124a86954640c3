"""The rig's instruments: what they make of the true state."""
