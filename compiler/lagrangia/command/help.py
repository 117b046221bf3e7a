"""`lag help`: the topics, or one of them."""

from argparse import Namespace

from lagrangia.base.diagnostics import fail
from lagrangia.command.parser import COMMANDS
from lagrangia.command.topics import TOPICS, topic_text


def help_command(options: Namespace) -> int:
    """Raises LagError where there is no such topic."""
    if options.topic is not None:
        if options.topic not in TOPICS and any(command.name == options.topic for command in COMMANDS):
            fail("L0707", f"there is no topic '{options.topic}'", None, f"of the command: lag {options.topic} --help")
        print(topic_text(options.topic))
        return 0
    print("Topics, each shown by `lag help TOPIC`:\n")
    for name, (summary, _) in TOPICS.items():
        print(f"  {name:12} {summary}")
    return 0
