"""From what a class handed in to one file of results: intake, isolation, verdicts."""
