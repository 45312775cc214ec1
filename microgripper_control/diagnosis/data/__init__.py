"""What recordings hold: the samples that are fitted and that judge, their noise, residuals."""
