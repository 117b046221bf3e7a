"""`lag help`: the topics, or one of them."""

from argparse import Namespace

from lagrangia.command.topics import TOPICS, topic_text


def help_command(options: Namespace) -> int:
    """Raises LagError where there is no such topic."""
    if options.topic is not None:
        print(topic_text(options.topic))
        return 0
    print("Topics, each shown by `lag help TOPIC`:\n")
    for name, (summary, _) in TOPICS.items():
        print(f"  {name:12} {summary}")
    return 0
