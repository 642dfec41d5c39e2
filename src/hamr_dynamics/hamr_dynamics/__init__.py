"""The physics, written once: floating base, contact, integration, tracer, compiled kernels and lanes. No rclpy, no torch."""
