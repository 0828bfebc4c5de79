"""Commands for devices and hardware: device, serve, drive, conform."""
