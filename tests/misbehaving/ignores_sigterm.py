"""A module that does not stop when it is asked to, nor when its daemon is gone."""

import signal
import sys
import threading

signal.signal(signal.SIGTERM, signal.SIG_IGN)
sys.stderr.write("stubborn is ready\n")
sys.stderr.flush()
threading.Event().wait(60.0)
