"""Numbers that the reports and the claims go by: functions of the rows of a table."""
