"""The framework of experiments: parameters, results, figures and the files of a run."""
