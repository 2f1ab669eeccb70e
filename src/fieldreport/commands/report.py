"""``fieldrecon report``: its options, and errors as one sentence.

The modules that compute and draw are imported only if something is out of date.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from fieldrecon._core.extras import require
from fieldreport.build import up_to_date
from fieldreport.build.errors import BuildError, disk_failure

INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``fieldrecon report``."""
    parser.add_argument(
        "--source",
        type=Path,
        default=Path("report"),
        metavar="DIR",
        help="folder of the text (default: %(default)s)",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the results (default: SOURCE/build)"
    )
    parser.add_argument(
        "--experiments",
        type=Path,
        metavar="FILE",
        help="parameters that differ from the defaults (default: SOURCE/experiments.toml)",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=os.cpu_count() or 1,
        metavar="N",
        help="number of worker processes (default: one per processor, %(default)s)",
    )
    parser.add_argument(
        "--only",
        nargs="+",
        default=[],
        metavar="EXPERIMENT",
        help="bring only these experiments up to date, without typesetting the text",
    )
    parser.add_argument(
        "--check-reproducible",
        action="store_true",
        help="then build again in other surroundings and compare every byte",
    )
    parser.add_argument(
        "--against",
        type=Path,
        metavar="MANIFEST",
        help="compare the facts with those of another machine's manifest.json",
    )
    parser.set_defaults(command=main)


def main(arguments: argparse.Namespace) -> int:
    """Build according to the options; print errors as sentences; return the exit status."""
    from fieldreport.build import reproducibility

    require("matplotlib", "fontTools", "pypandoc", "typst")
    try:
        if arguments.only or not up_to_date.is_up_to_date(arguments):
            from fieldreport.build.build import build

            build(arguments)
        if arguments.check_reproducible:
            return reproducibility.check(arguments)
        if arguments.against:
            return reproducibility.compare_facts(arguments)
    except BuildError as error:
        return _fail(error)
    except OSError as error:
        known = disk_failure(error)
        if known is None:
            raise
        return _fail(known)
    except KeyboardInterrupt:
        print("interrupted; the next build continues from here", file=sys.stderr)
        return INTERRUPTED
    return 0


def _fail(error: BuildError) -> int:
    print(f"fieldrecon report: {error}", file=sys.stderr)
    return 1
