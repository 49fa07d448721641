#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Asks oiiotool, which shares no code with us, whether a picture holds light.

usage: check_picture.py FILE WIDTH HEIGHT [CHANNEL ...]

Fails unless FILE has that size and all of the channels named, and every channel named (or, without
names, every channel) is finite, differs from pixel to pixel and has a positive maximum.
"""

import re
import subprocess
import sys


def statistics(path):
    """Channel names, size, and per channel the minimum, maximum and counts of NaN and infinities."""
    run = subprocess.run(["oiiotool", "--info", "-v", "--stats", path],
                         check=False, capture_output=True, text=True)
    if run.returncode:
        raise ValueError(f"oiiotool cannot read {path}:\n{run.stdout}{run.stderr}")
    text = run.stdout
    size = re.search(r":\s*(\d+) x\s*(\d+), (\d+) channel", text)
    names = re.search(r"channel list: (.+)", text)
    if not size or not names:
        raise ValueError(f"oiiotool did not describe {path}:\n{text}")
    rows = {}
    for key in ("Min", "Max", "NanCount", "InfCount"):
        row = re.search(rf"Stats {key}: ([^(\n]+)", text)
        if not row:
            raise ValueError(f"no 'Stats {key}' for {path}:\n{text}")
        rows[key] = [float(word) for word in row.group(1).split()]
    channels = [re.sub(r" \(.*\)$", "", name.strip()) for name in names.group(1).split(",")]
    return (int(size.group(1)), int(size.group(2))), channels, rows


def main():
    if len(sys.argv) < 4:
        print(__doc__, file=sys.stderr)
        return 2
    path, width, height, *wanted = sys.argv[1:]
    try:
        size, channels, rows = statistics(path)
    except ValueError as error:
        print(error)
        return 1
    wrong = []
    if size != (int(width), int(height)):
        wrong.append(f"it is {size[0]} x {size[1]}, not {width} x {height}")
    for name in wanted or channels:
        if name not in channels:
            wrong.append(f"it has no channel {name}, only {', '.join(channels)}")
            continue
        i = channels.index(name)
        low, high = rows["Min"][i], rows["Max"][i]
        if rows["NanCount"][i] or rows["InfCount"][i]:
            wrong.append(f"{name} holds NaN or infinities")
        if not high > 0 or not high > low:
            wrong.append(f"{name} is empty: from {low} to {high}")
    for reason in wrong:
        print(f"{path}: {reason}")
    if not wrong:
        print(f"{path}: {size[0]} x {size[1]}, {', '.join(wanted or channels)} hold light")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
