"""The command line: `skillfold fit | fit-keyframes | info | plan | project | simulate | demo | bench | reproduce`.

Every command is a frozen dataclass: its fields are the options, its `run` does the work and returns the exit
code. 0: done; 1: a plan that cannot be made, an experiment that ended with an error; 2: bad input, said in one line;
130: stopped by Ctrl-C. What a command reports goes to stdout, everything else (progress, notes, errors) to stderr.
"""

import os
import sys
from collections.abc import Sequence
from typing import Annotated

import tyro

from skillfold import __version__
from skillfold.cli import console
from skillfold.cli.keyframes import FitKeyframes
from skillfold.cli.learning import Fit, Info
from skillfold.cli.measuring import Bench, Demo
from skillfold.cli.planning import Plan, Project
from skillfold.cli.reproducing import Reproduce
from skillfold.cli.simulating import Simulate
from skillfold.errors import SkillfoldError

DONE, FAILED, BAD_INPUT, STOPPED = 0, 1, 2, 130

DESCRIPTION = (
    "Show a robot a skill a few times; plan new motions that hold it; bring states back to it. "
    "Lengths, residuals and distances are in the units of the recordings, angles in radians, times in seconds. "
    "`skillfold --version` tells the version."
)

Command = (
    Annotated[Fit, tyro.conf.subcommand("fit")]
    | Annotated[FitKeyframes, tyro.conf.subcommand("fit-keyframes")]
    | Annotated[Info, tyro.conf.subcommand("info")]
    | Annotated[Plan, tyro.conf.subcommand("plan")]
    | Annotated[Project, tyro.conf.subcommand("project")]
    | Annotated[Simulate, tyro.conf.subcommand("simulate")]
    | Annotated[Demo, tyro.conf.subcommand("demo")]
    | Annotated[Bench, tyro.conf.subcommand("bench")]
    | Annotated[Reproduce, tyro.conf.subcommand("reproduce")]
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    console.forgive()
    if arguments == ["--version"]:
        sys.stdout.write(f"skillfold {__version__}\n")
        return DONE
    try:
        return _parsed(arguments or ["--help"]).run()
    except SystemExit as stop:  # tyro has said why
        return stop.code if isinstance(stop.code, int) else BAD_INPUT
    except SkillfoldError as error:
        console.say(f"error: {error}")
        return BAD_INPUT
    except KeyboardInterrupt:
        console.say("stopped")
        return STOPPED
    except BrokenPipeError:  # such as `| head`: nobody reads on, and nothing is wrong
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


def _parsed(arguments: list[str]) -> Fit | FitKeyframes | Info | Plan | Project | Simulate | Demo | Bench | Reproduce:
    config = (tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff)
    return tyro.cli(Command, args=arguments, prog="skillfold", description=DESCRIPTION, config=config)  # type: ignore[return-value]
