"""The trusted side of the sandbox.

``server`` chooses the tier (bubblewrap, Landlock, none) and starts the forking server of
``fieldgrade.sandbox``; ``file_access`` determines the files that it can see. ``process`` talks to
one sandboxed process, ``session`` runs a whole submission, with deadlines. ``scratch`` removes
what a killed grader left behind. ``worker_servers`` keeps one server for each thread or process
that grades.
"""
