"""Numbers that the reports and the claims go by: of the rows of a table, and as published."""
