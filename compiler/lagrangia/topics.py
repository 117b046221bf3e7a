"""Longer texts, shown by `lag help TOPIC`."""

TOPICS = {"language": ("the language on one page", "")}


def topic_text(topic: str) -> str:
    return TOPICS[topic][1]
