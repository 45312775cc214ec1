"""From free displacement to position: masses, springs, dampers."""
