"""The rig's equations, one physical thing per module."""
