"""What was found, of one machine or of several together, as plain data that can be stored, compared and printed."""
