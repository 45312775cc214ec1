"""The demonstration: the whole suite at work on a simulated rig, and what came of it."""
