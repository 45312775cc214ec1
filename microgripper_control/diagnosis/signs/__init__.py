"""What residuals show without a fit: where the gap lies, and the signs of each effect."""
