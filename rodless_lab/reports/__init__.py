"""Pages and reports written from what the code gives."""
