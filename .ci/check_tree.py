#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the tree as git sees it: names at the top, licence lines, dead code, and that no file
leans on the machine it was written on. Prints file:line for each finding and exits 1.

Files that are new and not ignored count as well, so the check can run before a commit.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOP = {"core", "protocol", "server", "lenses", "tests", "deploy", "docs", "README.md",
       "CMakeLists.txt", "CMakePresets.json", "LICENSE"}
CODE = {".h", ".cpp", ".py", ".sh", ".cmake"}
TEXT = CODE | {".md", ".txt", ".json", ".yaml", ".yml", ".toml", ""}

# Patterns are written so that they do not match themselves.
EVERYWHERE = [
    (re.compile(r"(?<![\w.$}])/(wor[k]|hom[e]|roo[t]|User[s])/\w"), "a path of one machine"),
    (re.compile(r"\.\./share[d]\b"), "a path outside the tree"),
]
IN_CODE = [
    (re.compile(r"^\s*#\s*if 0\b"), "dead code"),
    (re.compile(r"\bDISABLE[D]_\w|GTEST_SKI[P]|EXPECT_TRUE\(tru[e]\)"), "a test that does not test"),
    (re.compile(r"\b(TOD[O]|FIXM[E])\b(?!\(#\d+\))"), "write it as TOD" "O(#issue number) or do it"),
]


def files():
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return sorted(name for name in listed.split("\0") if name and (ROOT / name).exists())


def findings(name):
    top = name.split("/")[0]
    if not top.startswith(".") and top not in TOP:
        yield 1, f"'{top}' is not one of the names at the top of the tree"
    path = ROOT / name
    if path.is_symlink():
        if ROOT not in path.resolve().parents:
            yield 1, "a link that leaves the tree"
        return
    if path.suffix not in TEXT:
        return
    data = path.read_bytes()
    if b"\0" in data:
        return
    lines = data.decode("utf-8", errors="replace").splitlines()
    is_script = bool(lines) and lines[0].startswith("#!")
    is_code = path.suffix in CODE or is_script
    if path.suffix in {".h", ".cpp", ".py"} or is_script:
        if not any("SPDX-License-Identifier: Apache-2.0" in line for line in lines[:2]):
            yield 1, "the licence line is missing"
    for number, line in enumerate(lines, 1):
        for pattern, why in EVERYWHERE + (IN_CODE if is_code else []):
            if pattern.search(line):
                yield number, why


def main():
    names = files()
    count = 0
    for name in names:
        for line, why in findings(name):
            print(f"{name}:{line}: {why}")
            count += 1
    print(f"{len(names)} files, {count} findings")
    return 1 if count or not names else 0


if __name__ == "__main__":
    sys.exit(main())
