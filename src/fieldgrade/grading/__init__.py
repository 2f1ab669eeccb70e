"""Grading a class: from submitted files to ``results.json``.

``grade_class`` starts pytest with the ``pytest_plugin``, whose items (``pytest_items``,
``instructor_items``) wait for the ``batch`` that runs the checks. ``run`` knows all folders of a
run, and the ``ledger`` logs what ran.
"""

FOR_WORKERS = ("fieldgrade.grading.shared_modules",)
"""The module that is imported once, before worker processes are forked."""
