"""The instructor's side of the course: notebooks, sandbox, grading and gradebook.

``authoring`` builds the notebooks and the bundle for students, and ``grader_validation`` tests the
graders. ``submissions`` reads submitted files. ``sandbox`` runs students' code and ``isolation``
controls it from outside. ``checking`` grades one submission, ``grading`` a class. ``class_folder``
reads the tables of the staff, and ``gradebook`` combines them with the results. ``commands`` has
the commands of ``fieldrecon``.
"""
