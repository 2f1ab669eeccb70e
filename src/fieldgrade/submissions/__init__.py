"""Submitted files: finding them, their owners and their content. Nothing is executed.

``unpack`` lists files in folders and zip files, ``bulk_downloads`` parses the names of Canvas,
Moodle and Gradescope, ``owners`` matches them to the roster, ``collection`` puts them into the
``archive``, and ``intake`` selects the file to be graded, with its ``helper_files``.
``submission``, ``definitions`` and ``written_answers`` read the content.
"""
