"""Other ways of doing the same: what ours is measured against, and shown to agree with."""
