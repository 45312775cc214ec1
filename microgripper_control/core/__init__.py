"""Parameters, signals, recordings and errors: what every other room stands on."""
