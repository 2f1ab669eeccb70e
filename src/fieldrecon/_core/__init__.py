"""What every room stands on: checked arguments, chunks and threads, files, processes, extras."""
