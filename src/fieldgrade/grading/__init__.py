"""From what a class handed in to one file of results: intake, isolation, verdicts."""

FOR_WORKERS = ("fieldgrade.grading.batch", "jupytext")
"""What processes that grade have imported before they start."""
