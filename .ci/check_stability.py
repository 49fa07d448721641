#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every test which docs/stability.md names exists, and that every suite of
tests/stability and tests/property is named there. Prints the findings and exits 1.

A name is `Suite.Test`, `Suite.Beginning*`, `Suite.*`, or `BothEngines/Scene` for a row of that
table."""

import fnmatch
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TEST = re.compile(r"^\s*(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP)\(\s*(\w+),\s*(\w+)", re.MULTILINE)
SCENE = re.compile(r"\{\"(\w+)\",\s*[\d.e-]+,")
NAMED = re.compile(r"`((?:[A-Z]\w*)\.(?:\w+\*?|\*)|BothEngines/\w+)`")


def tests_of(folder):
    found = set()
    for path in sorted((ROOT / folder).rglob("*_test.cpp")):
        found |= {f"{suite}.{name}" for suite, name in TEST.findall(path.read_text())}
    return found


def scenes():
    text = (ROOT / "tests/stability/pictures/both_engines_test.cpp").read_text()
    return {f"BothEngines/{name}" for name in SCENE.findall(text)}


def findings():
    document = (ROOT / "docs/stability.md").read_text()
    known = tests_of("tests") | scenes()
    named = NAMED.findall(document)
    if len(named) < 50:
        yield f"docs/stability.md names only {len(named)} tests"
    for name in named:
        if not fnmatch.filter(known, name):
            yield f"docs/stability.md names {name}, which no test is called"
    ours = tests_of("tests/stability") | tests_of("tests/property") | scenes()
    for test in sorted(ours):
        if not any(fnmatch.fnmatchcase(test, name) for name in named):
            if test != "BothEngines.DrawTheSamePicture":
                yield f"docs/stability.md does not name {test}"


def main():
    count = 0
    for finding in findings():
        print(finding)
        count += 1
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
