"""What tests read in a page."""

import base64
import json
import re
from html.parser import HTMLParser

from tierod.core.decimation import Packed, unpack


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


def series(text):
    """The traces that a page holds packed, by name."""
    found = re.search(r'<script type="application/json" id="series">(.*?)</script>', text, re.DOTALL)
    return {
        name: unpack(Packed(name, "", **{**head, "data": base64.b64decode(head["data"])}))
        for name, head in json.loads(found[1]).items()
    }
