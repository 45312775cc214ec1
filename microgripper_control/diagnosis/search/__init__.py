"""Which explanations are tried, and how far each is fitted."""
