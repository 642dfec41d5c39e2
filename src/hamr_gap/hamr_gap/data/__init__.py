"""What was measured: tables and bags as records, times made even, what readings say about their sensors, sizes in SI."""
