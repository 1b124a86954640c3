"""The long runs themselves, with nodes over DDS."""
