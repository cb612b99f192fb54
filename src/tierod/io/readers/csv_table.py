"""The text of a table (CSV) in UTF-8, in blocks of whole lines; nothing of it is kept."""

from __future__ import annotations

import codecs
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from tierod.io.readers.content import Content, whole_lines
from tierod.io.readers.csv_layout import SAMPLE, Layout


@dataclass(frozen=True)
class Table:
    """A text table.

    Args:
        content: the bytes of the file
        layout: how they are laid out
        end: of a line
        size: bytes of the unpacked text in UTF-8
        lines: of data
        quotes: quotation marks in the data
    """

    content: Content
    layout: Layout
    end: bytes
    size: int
    lines: int
    quotes: int

    def blocks(self) -> Iterator[bytes]:
        """The lines of data, some megabytes at a time."""
        return whole_lines(_below(_in_utf8(self.content), self.layout.begin), self.content.path, self.quoted, self.end)

    @property
    def quoted(self) -> bool:
        """Whether quotation marks quote; not where their number is odd: an open one would hide lines up to the next."""
        return self.quotes > 0 and self.quotes % 2 == 0


def head_of(content: Content) -> bytes:
    """The beginning of the text, more than the layout is found from, in UTF-8.

    Args:
        content: the bytes of the file
    """
    head = b""
    for block in _in_utf8(content):
        head += block
        if len(head) > SAMPLE:
            break
    return head


def counted(content: Content, layout: Layout, end: bytes) -> Table:
    """A table whose text was read once from beginning to end, to count its bytes, lines and quotation marks.

    Args:
        content: the bytes of the file
        layout: how they are laid out
        end: of a line
    """
    size = lines = quotes = 0
    last = b""
    for block in _below(_in_utf8(content), layout.begin):
        size, last = size + len(block), block[-1:]
        lines += block.count(end)
        quotes += block.count(b'"')
    return Table(content, layout, end, size, lines + (last != end), quotes)


def _below(blocks: Iterable[bytes], begin: int) -> Iterator[bytes]:
    """The blocks without the first bytes."""
    for block in blocks:
        if begin < len(block):
            yield block[begin:]
        begin = max(begin - len(block), 0)


def _in_utf8(content: Content) -> Iterator[bytes]:
    """The text as it is, or in UTF-8 where it is in UTF-16."""
    decoder: Any = None
    for place, block in enumerate(content.blocks()):
        if place == 0 and block[:2] in (b"\xff\xfe", b"\xfe\xff"):
            decoder = codecs.getincrementaldecoder("utf-16")(errors="replace")
        yield block if decoder is None else decoder.decode(block).encode()
    if decoder is not None:
        yield decoder.decode(b"", final=True).encode()
