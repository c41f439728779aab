"""What a report shows: its data, decoded anew."""

import base64
import json
import re
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np


def data_of(page: Path | str) -> dict:
    """JSON part of the data of a report, given as its file or its text."""
    return columns_of(page)[0]


def log_of(page: Path | str) -> list[str]:
    """Sentences of a report's log."""
    return [text for _, _, _, text, _ in data_of(page)["log"]]


def columns_of(page: Path | str) -> tuple[dict, Callable[[int], np.ndarray]]:
    """Data of a report, given as its file or its text: JSON, and a function from the index of a column to its rows."""
    text = page.read_text("utf-8") if isinstance(page, Path) else page
    return unpacked(base64.b64decode(re.search(r'id="data">([^<]*)<', text)[1]))


def steps(column: Callable[[int], np.ndarray], t: int | list[int], v: int | list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Times and rows of a packed track, also of one with columns of its own for each side."""
    if isinstance(t, int):
        return column(t)[:, 0], column(v)
    parts = [(column(i)[:, 0], column(k)[:, 0]) for i, k in zip(t, v, strict=True)]
    times = np.unique(np.concatenate([each for each, _ in parts]))
    found = [values[np.maximum(np.searchsorted(each, times, side="right") - 1, 0)] for each, values in parts]
    return times, np.stack(found, axis=1)


def unpacked(data: bytes) -> tuple[dict, Callable[[int], np.ndarray]]:
    """Packed data: JSON, and a function from the index of a column to its rows."""
    raw = zlib.decompress(data)
    length = int.from_bytes(raw[:4], "little")
    about, at, starts = json.loads(raw[4 : 4 + length]), 4 + length, []
    for count, _, _, size, *_ in about["columns"]:
        starts.append(at)
        at += count * size
    assert at == len(raw)

    def column(i):
        count, width, resolution, size, *top = about["columns"][i]
        planes = np.frombuffer(raw, np.uint8, count * size, starts[i]).reshape(size, width, -1).astype(np.int64)
        unsigned = sum(planes[k] << (8 * k) for k in range(size))
        whole = np.cumsum((unsigned >> 1) ^ -(unsigned & 1), axis=1).T
        whole = (whole + 2**31) % 2**32 - 2**31
        if resolution == 1.0:
            return whole
        real = whole * resolution
        for greatest in top:
            for above, value in enumerate((np.inf, np.nan, -np.inf), 1):
                real[whole == greatest + above] = value
        return real

    return about, column


def resize(browser, width=1366, height=768, scale=1):
    """Set the size of a browser's window."""
    screen = {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **screen)
