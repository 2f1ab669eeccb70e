"""The experiments and the report: from parameters to results, figures, and an HTML page and a PDF.

``experiments`` holds them by topic, ``framework`` says what an experiment is, and ``build`` brings
the report up to date. The commands are ``fieldrecon experiments`` and ``fieldrecon report``.
"""
