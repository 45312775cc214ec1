"""From the finger's position to the number that is recorded."""
