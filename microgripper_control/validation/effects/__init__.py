"""What the rig has and the user's model lacks: one effect a file, in two functional forms."""
