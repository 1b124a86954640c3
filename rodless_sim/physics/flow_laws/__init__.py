"""The laws of flow that ``valve.flow_law`` chooses from."""
