"""What tests read in a page."""

import base64
import json
import re
import zlib
from html.parser import HTMLParser

import numpy as np

from tierod.core.decimation import MISSING, Packed
from tierod.core.findings import Trace


class Page(HTMLParser):
    """What a browser would see: elements, identifiers, and whether every element is closed."""

    VOID = frozenset({"meta", "link", "br", "hr", "img", "input", "line", "circle", "wbr"})

    def __init__(self, text):
        super().__init__()
        self.open, self.identifiers, self.attributes, self.texts = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.attributes.append((tag, dict(attrs)))
        self.identifiers += [value for key, value in attrs if key == "id"]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.attributes.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("script", "style"):
            self.texts.append(data)


def charts(text):
    found = re.findall(r'<script type="application/json" class="figure">(.*?)</script>', text, re.DOTALL)
    return {chart["name"]: chart for chart in map(json.loads, found)}


def unpack(packed):
    low, high = np.frombuffer(zlib.decompress(packed.data), np.uint8).astype(int).reshape(2, -1)
    turned, above, below = (low + 256 * high).reshape(3, -1)
    middle = np.cumsum((turned >> 1) ^ -(turned & 1)) % 2**16
    codes = np.where(middle == MISSING, np.nan, [middle - below, middle + above, middle])
    values = packed.lowest + packed.step * (codes - 1.0)
    return Trace(packed.name, packed.unit, packed.start + packed.width * np.arange(packed.count), *values)


def series(text):
    """The traces that a page holds packed, by name."""
    found = re.search(r'<script type="application/json" id="series">(.*?)</script>', text, re.DOTALL)
    return {
        name: unpack(Packed(name, "", **{**head, "data": base64.b64decode(head["data"])}))
        for name, head in json.loads(found[1]).items()
    }
