"""What a user would do instead of a diagnosis, on the same recordings and the same splits."""
