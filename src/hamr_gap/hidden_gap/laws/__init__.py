"""Every law that may be hidden, by what it acts on; importing this folder registers them all."""

from . import actuator, body, friction, outside, outside_devices, outside_memory, piezo, sensor, springs

__all__ = ["actuator", "body", "friction", "outside", "outside_devices", "outside_memory", "piezo", "sensor", "springs"]
