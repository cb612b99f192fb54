"""Extraction of signals from the payload bytes of many frames at once: any start bit and length, both byte orders."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

_REALS = {16: (np.uint16, np.float16), 32: (np.uint32, np.float32), 64: (np.uint64, np.float64)}

LONGEST = 64  # Largest number of bits of a number; longer signals hold texts, keys or checksums


def span(start: int, length: int, big_endian: bool) -> tuple[int, int]:
    """(first bit, bit after the last) of a signal, in the order of its bits.

    Bits count from the highest bit of the first byte where the signal is big endian, else from its lowest bit.
    """
    begin = 8 * (start // 8) + 7 - start % 8 if big_endian else start
    return begin, begin + length


@dataclass(frozen=True)
class Payloads:
    """The payloads of the frames of one message, with their bytes as 64-bit words, which are made once."""

    data: np.ndarray  # bytes, shape (n, width); zero beyond the end of a short frame
    # 64-bit words made so far, by (byte they begin at, byte order)
    words: dict[tuple[int, bool], np.ndarray] = field(default_factory=dict)

    def word(self, first: int, big_endian: bool) -> np.ndarray:
        """The eight bytes from `first` on as unsigned words, shape (n,)."""
        if (first, big_endian) not in self.words:
            part = self.data[:, first : first + 8]
            if part.shape[1] < 8:
                part = np.pad(part, ((0, 0), (0, 8 - part.shape[1])))
            word = np.ascontiguousarray(part).view(">u8" if big_endian else "<u8")[:, 0]
            self.words[first, big_endian] = word.astype(np.uint64)
        return self.words[first, big_endian]

    def raw(self, start: int, length: int, big_endian: bool, signed: bool = False, real: bool = False) -> np.ndarray:
        """The raw values of one signal, (n,), before factor and offset; NaN where it is described as no number."""
        if not 1 <= length <= LONGEST or start < 0 or (real and length not in _REALS):
            return np.full(len(self.data), np.nan)
        begin, end = span(start, length, big_endian)
        first = 0 if end <= 64 else begin // 8
        begin, end = begin - 8 * first, end - 8 * first
        value = self.word(first, big_endian)
        # Shifted up to the end of the word and down again, which extends the sign of a signed signal.
        if end <= 64:
            above = begin if big_endian else 64 - end
            value = value << np.uint64(above) if above else value
        else:
            value = self._across_nine_bytes(value, first, begin, end, big_endian)
        below = 64 - length
        if real:
            bits, kind = _REALS[length]
            return (value >> np.uint64(below)).astype(bits).view(kind)
        if signed:
            return value.view(np.int64) >> np.int64(below)
        return value >> np.uint64(below)

    def _across_nine_bytes(self, value: np.ndarray, first: int, begin: int, end: int, big_endian: bool) -> np.ndarray:
        """Bits of a signal that covers nine bytes, shifted to the upper end of a word."""
        ninth = self.word(first + 8, big_endian)
        if big_endian:
            return (value << np.uint64(begin)) | (ninth >> np.uint64(64 - begin))
        below = (value >> np.uint64(begin)) | (ninth << np.uint64(64 - begin))
        return below << np.uint64(64 - (end - begin))
