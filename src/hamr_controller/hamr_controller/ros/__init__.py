"""What the nodes share: QoS table, parameters, process frame, diagnostics, the simulator node and the driver's loop."""
