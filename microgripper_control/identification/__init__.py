"""Fits the model to recordings and says how far the numbers can be trusted."""
