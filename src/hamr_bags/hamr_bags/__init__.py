"""Excitation signals and bags: record, read, check, repair; excitation and recorder nodes."""
