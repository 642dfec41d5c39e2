"""What would decide between names: drive signals, and how far apart they would set what each name reads."""
