"""The `microgripper` command."""

from __future__ import annotations

import sys

import typer

from microgripper_control.cli.bench import bench
from microgripper_control.cli.demo import demo
from microgripper_control.cli.diagnose import diagnose, spread_heldout
from microgripper_control.cli.identify import identify
from microgripper_control.cli.paper import paper
from microgripper_control.cli.repair import repair
from microgripper_control.cli.simulate import simulate
from microgripper_control.cli.stiffness import stiffness
from microgripper_control.cli.validate import validate
from microgripper_control.core.errors import MicrogripperError

app = typer.Typer(
    help="Simulate, control, identify and diagnose a piezo microgripper.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (identify, simulate, diagnose, validate, stiffness, repair, paper, demo, bench):
    app.command(no_args_is_help=command is not demo)(command)


BAD_INPUT = 2


def main() -> None:
    """Run the command line: exit status 0 on success, 2 on bad input with one line on stderr."""
    try:
        app(spread_heldout(sys.argv[1:]))
    except MicrogripperError as error:
        print(f"microgripper: {error}", file=sys.stderr)
        sys.exit(BAD_INPUT)
