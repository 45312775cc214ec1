"""The examination of the diagnosis: on rigs it has never seen, whose effect it is not told."""
