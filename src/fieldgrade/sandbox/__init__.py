"""What runs beside a student's code: it knows how to call it and how to lock it in, nothing else.

This package is copied to a folder of its own and runs there in an otherwise empty fieldrecon, so
that no solution, no expected value and no tolerance is on its side.
"""
