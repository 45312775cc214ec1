"""The command voltage on its way to the stack."""
