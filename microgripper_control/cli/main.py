"""The `microgripper` command."""

from __future__ import annotations

import errno
import io
import os
import sys
from typing import Any

import typer

from microgripper_control.cli.bench import bench
from microgripper_control.cli.demo import demo
from microgripper_control.cli.diagnose import diagnose, spread_heldout
from microgripper_control.cli.effects import effects
from microgripper_control.cli.identify import identify
from microgripper_control.cli.paper import paper
from microgripper_control.cli.repair import repair
from microgripper_control.cli.simulate import simulate
from microgripper_control.cli.stiffness import stiffness
from microgripper_control.cli.tune import tune
from microgripper_control.cli.validate import validate
from microgripper_control.core.errors import MicrogripperError, one_line

app = typer.Typer(
    help="Simulate, control, identify and diagnose a piezo microgripper.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
COMMANDS = (
    identify,
    simulate,
    diagnose,
    tune,
    effects,
    validate,
    stiffness,
    repair,
    paper,
    demo,
    bench,
)
for command in COMMANDS:
    app.command(no_args_is_help=command not in (demo, effects))(command)


BAD_INPUT = 2
STANDARD_OUTPUT = 1  # its descriptor
VALIDATORS_OWN = "Value error, "  # what typer's validator says before what is wrong
UsageError: Any = typer.BadParameter.__base__  # typer exports it not, and may bring its own click


def main() -> None:
    """Run the command line: exit status 0 on success, 2 on bad input with one line on stderr."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files need not be UTF-8
    try:
        sys.exit(app(spread_heldout(sys.argv[1:]), standalone_mode=False))
    except MicrogripperError as error:
        problem = str(error)
    except OSError as error:
        problem = _mendable(error)
    except UsageError as error:
        problem = one_line(error.format_message()).replace(VALIDATORS_OWN, "")
        if not problem:  # no arguments at all: the help has been shown instead
            sys.exit(BAD_INPUT)
        problem = problem.rstrip(".")
        if error.ctx is not None:
            problem += f"; see {error.ctx.command_path} --help"
    print(f"microgripper: {problem}", file=sys.stderr)
    sys.exit(BAD_INPUT)


def _mendable(error: OSError) -> str:
    """What to say of an error that the user can mend; any other is raised again."""
    if error.errno == errno.ENAMETOOLONG:
        return f"{error.filename!s:.60}...: is too long a name for a file"
    if error.errno in (errno.ENOSPC, errno.EIO) and error.filename is None:
        # At its end Python would try to write once more what is left, and complain at length.
        os.dup2(os.open(os.devnull, os.O_WRONLY), STANDARD_OUTPUT)
        return f"the output cannot be written: {error.strerror}"
    raise error
