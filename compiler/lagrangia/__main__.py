"""`python -m lagrangia`: the command `lag`."""

import sys

from lagrangia.command.cli import main

sys.exit(main())
