"""Numbers that the reports and the claims go by: registered functions of the rows of a table."""
