"""The rig's instruments: models that turn true values into readings."""
