"""The folder of a class: CSV tables that the staff writes.

``roster``, ``assignments`` (with the ``late_policy``), ``overrides`` (and regrade requests) and
``manual_grading`` (marks for written answers) are read with ``csv_tables``, and combined in
``decisions``. ``example_tables`` writes empty tables with examples, and ``example`` the class of
five students in ``example_class/``.
"""
