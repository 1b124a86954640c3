"""The valve from flows measured on a stand of its own."""
