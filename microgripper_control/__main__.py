"""`python -m microgripper_control`: the `microgripper` command."""

from microgripper_control.cli.main import main

main()
