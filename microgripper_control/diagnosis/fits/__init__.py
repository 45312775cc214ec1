"""One explanation fitted to the evidence, and what may be said of the fit."""
