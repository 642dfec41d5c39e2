"""The leg controller: PD law in volts at 20 kHz, the servo bus between processes, and the node behind the topics."""
