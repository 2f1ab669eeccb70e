"""Grading one submission: run in the sandbox, judged outside.

``grade_submission`` runs the checks of a ``course`` and makes a record (``results``, with a JSON
schema). ``check_results`` are kept in the ``cache`` under ``dependency_digests``, so that only
affected checks run again. ``missing_names`` says why a function is missing. ``instructor_checks``
are pytest functions that an instructor adds.
"""
