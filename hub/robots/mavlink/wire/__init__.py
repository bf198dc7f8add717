"""MAVLink frames: formats, checksums, signatures; pure except the file of a signing clock."""
