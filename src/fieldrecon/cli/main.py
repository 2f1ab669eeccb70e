"""The command line of ``fieldrecon``."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Collection, Sequence
from importlib.metadata import version
from typing import TextIO

from fieldrecon.cli.commands import ELSEWHERE, commands

USER_ERRORS = (ValueError, OSError, MemoryError, OverflowError, ImportError)
"""Errors that the user can correct; a LinAlgError is a ValueError."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 2 for errors that the user can correct."""
    arguments = sys.argv[1:] if arguments is None else arguments
    _replace_unencodable_characters(sys.stdout)
    options = _parser(arguments).parse_args(arguments)
    try:
        return options.command(options) or 0
    except KeyboardInterrupt:
        print("fieldrecon: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader has closed the pipe, as head does: this is not an error, and output stops.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except USER_ERRORS as error:
        if options.traceback:
            raise
        print(f"fieldrecon: {_sentence(error)}", file=sys.stderr)
        return 2


def _replace_unencodable_characters(stream: TextIO) -> None:
    """Write a question mark for a character that a Windows code page lacks, as in a redirection."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="replace")


def _parser(arguments: Sequence[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fieldrecon", description="Reconstruct a field from scattered samples."
    )
    parser.add_argument(
        "--version", action="version", version=f"fieldrecon {version('fieldrecon')}"
    )
    parser.add_argument("--traceback", action="store_true", help="show where an error came from")
    installed = commands()
    _refuse_missing_command(parser, next((a for a in arguments if a[:1] != "-"), ""), installed)
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, command in installed.items():
        try:
            command.add_to(subparsers, name, name in arguments)
        except ModuleNotFoundError as missing:
            parser.error(_sentence(missing))
    return parser


def _refuse_missing_command(
    parser: argparse.ArgumentParser, name: str, installed: Collection[str]
) -> None:
    """Name the distribution of a command that is not installed."""
    if name in ELSEWHERE and name not in installed:
        from fieldrecon._core.extras import companion

        parser.error(f"the command {name!r} comes with {companion(ELSEWHERE[name])}")


def _sentence(error: Exception) -> str:
    if isinstance(error, ModuleNotFoundError) and error.name:
        from fieldrecon._core.extras import remedy

        return remedy(error.name)
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror.lower()}" if error.filename else error.strerror
    return " ".join(str(error).split()) or type(error).__name__


if __name__ == "__main__":
    sys.exit(main())
