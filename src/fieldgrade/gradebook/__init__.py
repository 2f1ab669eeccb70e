"""From the file of results to what people read: grade book, feedback, platforms, analysis."""
