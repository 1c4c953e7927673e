"""A process in which nothing has been said yet."""

from fastdyn.compile import memory, sentences
from fastdyn.run import again


def unsaid(monkeypatch):
    """Forget what was said, and the kept runs, which say nothing again."""
    monkeypatch.setattr(sentences, "_warned", memory.Table())
    monkeypatch.setattr(again, "calls", memory.Table())
