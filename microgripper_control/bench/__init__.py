"""How fast the package is, as ratios to other ways of doing the same, side by side in one run."""
