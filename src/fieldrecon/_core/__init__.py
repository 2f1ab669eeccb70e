"""Foundations of the library: checked arguments, duplicates, chunks, files, processes, extras."""
