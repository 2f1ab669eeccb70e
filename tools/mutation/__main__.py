"""Mutation testing: mutants of single statements of the library, each run against its tests.

A mutant is caught if one of the tests that reach its statement fails; those that survive are
printed.

    python -m tools.mutation [--seed 1] [--count 200] [--jobs 2]

The copy of the checkout, the coverage of each test and the results so far are in build/mutation,
so that an interrupted run goes on where it stopped. Survivors that no test can catch, because the
mutant computes the same, are listed with the reason in equivalent.toml, and are not drawn again.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from tools.mutation.judged import ROOT, outdated
from tools.mutation.mutants import Mutant, drawn
from tools.mutation.reach import ONE_THREAD, WORK, digest, reach
from tools.mutation.trials import compile_tests, copy_of_checkout, trials

REQUIRED = 0.92
"""Share of the mutants that the tests must catch."""


def report(mutants: Sequence[Mutant], outcomes: dict[str, str]) -> bool:
    """Print the survivors and the share of mutants that were caught; return whether it suffices."""
    left = [mutant for mutant in mutants if outcomes[repr(mutant)] != "caught"]
    for mutant in left:
        before, after = mutant.lines((ROOT / mutant.path).read_text())
        print(f"\n{mutant.path}:{mutant.statement[0]} {outcomes[repr(mutant)]}")
        print("\n".join(f"- {line}" for line in before.splitlines()))
        print("\n".join(f"+ {line}" for line in after.splitlines()))
    for entry in outdated():
        print(f"\nnot in the code any more: {entry}")
    share = 1 - len(left) / len(mutants)
    print(
        f"\n{len(mutants) - len(left)} of {len(mutants)} mutants caught: {share:.1%}; "
        f"{REQUIRED:.0%} are required"
    )
    return share >= REQUIRED


def main() -> int:
    """Draw mutants, try them, and report."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.mutation", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--seed", type=int, default=1, help="of the draw of mutants (1)")
    parser.add_argument("--count", type=int, default=200, help="number of mutants (200)")
    parser.add_argument("--jobs", type=int, default=2, help="mutants tried at the same time (2)")
    options = parser.parse_args()
    os.environ |= ONE_THREAD
    WORK.mkdir(parents=True, exist_ok=True)
    mutants = drawn(options.seed, options.count)
    folders = [copy_of_checkout(f"copy-{k}") for k in range(options.jobs)]
    known = reach(folders[0], options.jobs)
    compile_tests(folders)
    outcomes = trials(mutants, known, folders, WORK / f"results-{digest()}.jsonl")
    return 0 if report(mutants, outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
