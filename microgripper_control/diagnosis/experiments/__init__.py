"""The voltage that would tell more."""
