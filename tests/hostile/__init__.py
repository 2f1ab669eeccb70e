"""Submissions that nobody wants and every class hands in: a fair grade each, and no harm done."""
