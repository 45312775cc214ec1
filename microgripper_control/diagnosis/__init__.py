"""The gap between simulation and rig: where it lies, what causes it, how far it can be closed."""
