"""From ``solutions/*.py`` to the notebooks of students and instructors.

A source (``sources``) becomes the student's notebook with stubs and the executed solution
(``notebooks``, ``build``, ``publish``), and the zip file for students (``bundle``); ``leaks`` keeps
solutions out of it. ``catalogue`` reads catalogued mistakes and alternative answers,
``hidden_cases`` the cases of the grader. ``trials`` are the inputs of an answer with their
``known_answers``; hidden inputs are drawn from the ``secret_salt``.
"""
