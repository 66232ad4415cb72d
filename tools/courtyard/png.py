"""A PNG writer whose bytes do not depend on the installed zlib.

The deflate stream is one block of dynamic Huffman codes without matches: noise textures
gain little from matches, and a different zlib build must not change the committed file.
"""

import heapq
import struct
import zlib

# The order in which a deflate header stores the lengths of the code-length code.
_LENGTH_ORDER = (16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15)


def _code_lengths(counts, limit):
    """Huffman code lengths of at most `limit` bits for the symbols with a count."""
    counts = list(counts)
    while True:
        heap = [(c, s, (s,)) for s, c in enumerate(counts) if c]
        heapq.heapify(heap)
        lengths = [0] * len(counts)
        serial = len(counts)
        while len(heap) > 1:
            c0, _, s0 = heapq.heappop(heap)
            c1, _, s1 = heapq.heappop(heap)
            for symbol in s0 + s1:
                lengths[symbol] += 1
            heapq.heappush(heap, (c0 + c1, serial, s0 + s1))
            serial += 1
        if max(lengths) <= limit:
            return lengths
        counts = [(c + 1) // 2 + 1 if c else 0 for c in counts]


def _codes(lengths):
    """Canonical codes, bit-reversed for deflate's order."""
    codes, code = {}, 0
    for length in range(1, 16):
        for symbol, own in enumerate(lengths):
            if own == length:
                codes[symbol] = (int(format(code, f"0{length}b")[::-1], 2), length)
                code += 1
        code <<= 1
    return codes


def deflate(data):
    """A zlib stream that holds `data`."""
    counts = [0] * 257
    for byte in data:
        counts[byte] += 1
    counts[256] = 1
    lengths = _code_lengths(counts, 15)
    distance_lengths = [1, 1]  # unused, but a complete code
    header = lengths + distance_lengths
    header_counts = [0] * 19
    for length in header:
        header_counts[length] += 1
    header_lengths = _code_lengths(header_counts, 7)

    out, acc, filled = bytearray(), 0, 0

    def put(value, bits):
        nonlocal acc, filled
        acc |= value << filled
        filled += bits
        while filled >= 8:
            out.append(acc & 255)
            acc >>= 8
            filled -= 8

    put(1, 1)  # last block
    put(2, 2)  # dynamic codes
    put(len(lengths) - 257, 5)
    put(len(distance_lengths) - 1, 5)
    put(19 - 4, 4)
    for symbol in _LENGTH_ORDER:
        put(header_lengths[symbol], 3)
    header_codes = _codes(header_lengths)
    for length in header:
        put(*header_codes[length])
    codes = _codes(lengths)
    for byte in data:
        put(*codes[byte])
    put(*codes[256])
    put(0, (8 - filled) % 8)
    return b"\x78\x01" + bytes(out) + struct.pack(">I", zlib.adler32(data))


def _chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _png(width, height, color_type, stride, pixels, extra):
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        rows += pixels[y * stride:(y + 1) * stride]
    head = struct.pack(">IIBBBBB", width, height, 8, color_type, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", head) + extra
            + _chunk(b"IDAT", deflate(bytes(rows))) + _chunk(b"IEND", b""))


def indexed(width, height, indices, palette, alphas=()):
    """A palette image; `alphas` gives the alpha of the first palette entries."""
    extra = _chunk(b"PLTE", bytes(c for color in palette for c in color))
    if alphas:
        extra += _chunk(b"tRNS", bytes(alphas))
    return _png(width, height, 3, width, bytes(indices), extra)


def rgb(width, height, pixels):
    """A true-colour image from 3 bytes per texel."""
    return _png(width, height, 2, 3 * width, bytes(pixels), b"")
