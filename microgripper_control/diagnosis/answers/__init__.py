"""From what was tried to probabilities, names and sentences."""
