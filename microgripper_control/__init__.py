"""Simulate, control, identify and diagnose a piezo microgripper."""
