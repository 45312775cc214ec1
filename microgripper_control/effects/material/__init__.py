"""From voltage to free displacement: the piezo ceramic."""
