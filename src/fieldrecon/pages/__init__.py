"""Pages of HTML and other reports that the commands write beside their results."""
