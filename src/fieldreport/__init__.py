"""The experiments and the report: from parameters to results, figures, and an HTML page and a PDF.

``experiments`` has the experiments by topic, ``framework`` defines the parts of an experiment, and
``build`` brings the report up to date. The commands are ``fieldrecon experiments`` and
``fieldrecon report``.
"""
