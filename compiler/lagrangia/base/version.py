"""The version of the compiler, in one place: `lag --version` tells it, and an FMU says by it what made it."""

VERSION = "0.1.0"
