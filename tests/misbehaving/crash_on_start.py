"""A module that ends as soon as it is started."""

import sys

sys.exit(7)
