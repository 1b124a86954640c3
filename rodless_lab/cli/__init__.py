"""The `rodless` command: arguments in, text out, one verb per module."""
