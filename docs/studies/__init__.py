"""Studies whose tables and figures stand in docs: many systems each, minutes to an hour, a command of their own."""
