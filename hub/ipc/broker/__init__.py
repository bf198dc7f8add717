"""Central: it forwards messages, answers control messages, and bounds what each client uses."""
