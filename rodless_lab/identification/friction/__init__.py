"""Friction of the carriage from uniform motion, breakaways and stops."""
