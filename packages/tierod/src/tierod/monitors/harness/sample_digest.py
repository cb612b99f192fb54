"""Fingerprint of the samples of a recording, which identifies it in another file or under another name."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np

from tierod.core.recording import Recording


class SampleDigest:
    """SHA-256 over time stamps and values; it does not depend on how the recording is cut into pieces.

    Args:
        names: channels to be included, if the recording has them
    """

    def __init__(self, names: Iterable[str]):
        self._digests = {name: hashlib.sha256(name.encode()) for name in sorted(names)}

    def add(self, piece: Recording) -> None:
        """Add the next piece of the recording."""
        for name, digest in self._digests.items():
            if name in piece:
                channel = piece[name]
                digest.update(np.column_stack([channel.time, channel.values]).astype("<f8").tobytes())

    def result(self) -> str:
        """First 32 hexadecimal digits of the digest over all pieces."""
        whole = hashlib.sha256(b"".join(digest.digest() for digest in self._digests.values()))
        return whole.hexdigest()[:32]
