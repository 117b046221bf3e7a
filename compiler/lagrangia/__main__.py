"""`python -m lagrangia`: the command `lag`."""

import sys

from lagrangia.cli import main

sys.exit(main())
