"""From the actuator to the finger."""
