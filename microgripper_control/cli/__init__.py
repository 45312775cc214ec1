"""The `microgripper` command."""
