"""From results and decisions to final grades, pages and exports.

``grade_sheets`` computes the final points: automatic grades, manual marks, overrides, late
penalties. ``exports`` writes the gradebook and the files for Canvas, Moodle and Gradescope;
``feedback`` the page of a student; ``class_report`` the report on a class. ``item_analysis`` has
statistics of the questions, ``similarity`` finds similar answers, and ``differences`` lists changed
grades.
"""
