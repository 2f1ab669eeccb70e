"""What an experiment is: its parameters, its result, its figures, and the files of a run."""
