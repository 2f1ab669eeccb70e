"""Submissions that nobody wants and every class hands in: each has a fair grade, and harms nobody."""
