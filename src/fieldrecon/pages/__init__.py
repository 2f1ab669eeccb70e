"""Pages of HTML that the commands write beside their results."""
