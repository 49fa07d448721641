#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks every #include of core/, protocol/ and server/ against the layers.

CMake refuses a layer that *links* upwards or sideways; this refuses a file that *includes* what its
layer does not use, or a library that belongs to another. Layers, ranks and uses are read from the
flare_layer() calls, so they stand in one place. Prints file:line for each breach and exits 1.

usage: check_layers.py [ROOT]
"""

import pathlib
import re
import sys

SIDES = ("core", "protocol", "server")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
LAYER = re.compile(r"flare_layer\(\s*(\w+)\s+(\d+)\s([^()]*)\)")
PROGRAM = re.compile(r"add_executable\(\s*\w+\s([^()]*)\)")
KEYWORDS = ("SOURCES", "USES", "PRIVATE", "PUBLIC")

# Who may speak both languages: the core's types and the wire's.
TRANSLATORS = re.compile(r"server/(translate/|cli/|service\.)")
WIRE = re.compile(r"protocol/(wire|codec)/")
CORE_TYPE = re.compile(r"core/(?!base/)")

# A heavy library is seen by these files and no others: (name, headers, files).
LIBRARIES = [
    ("nlohmann-json", r"nlohmann/", r"protocol/codec/"),
    ("toml++", r"toml\+\+/", r"core/prescription/toml_document\.cpp|server/config(_encoders)?\.(cpp|h)"),
    ("libusb", r"(libusb|ftdi)\.h", r"server/encoder/usb_"),
    ("Boost", r"boost/", r"server/http/|protocol/client/"),
    ("OpenEXR", r"(OpenEXR/|Imf|Iex|IlmThread)", r"core/image/exr_(header|decode)\.cpp"),
    ("Highway", r"hwy/", r"core/tracing/trace_columns|core/mesh/passage_columns|core/image/(tile_kernels|blur_rows)"),
    ("kissfft", r"kissfft/", r"core/wave/fourier\.cpp"),
    ("libpng", r"png\.h", r"core/image/(preview|mask_image)\.cpp"),
    ("xxHash", r"xxh", r"core/base/fingerprint\.cpp"),
    ("prometheus-cpp", r"prometheus/", r"server/"),
    ("spdlog", r"(spdlog|fmt)/", r"server/"),
    ("CLI11", r"CLI/", r"server/"),
    ("Imath", r"Imath/", r"core/"),
    ("pugixml", r"pugi", r"core/lens_import/openlensflare_reader\.cpp"),
]

# The core knows no file, clock, log or socket: readers take bytes, writers return bytes.
OUTSIDE_WORLD = re.compile(
    r"(fstream|iostream|filesystem|chrono|ctime|time\.h|unistd\.h|fcntl\.h|sys/|netinet/|arpa/)"
)


class Layer:
    def __init__(self, name, rank, uses, shared=False):
        self.name, self.rank, self.uses, self.shared = name, rank, uses, shared


class Layers:
    """Which layer a file belongs to, and what a layer sees."""

    def __init__(self, root):
        self.by_name, self.by_source, self.declared_in = {}, {}, {}
        self.programs = set()
        for side in SIDES:
            for file in sorted((root / side).rglob("CMakeLists.txt")):
                self._read(file, file.parent.relative_to(root).as_posix())

    def _read(self, file, folder):
        text = re.sub(r"#[^\n]*", "", file.read_text(encoding="utf-8"))
        for name, rank, rest in LAYER.findall(text):
            lists, current = {word: [] for word in KEYWORDS}, None
            for word in rest.split():
                if word in KEYWORDS:
                    current = lists[word]
                elif current is not None:
                    current.append(word)
            layer = Layer(name, float(rank), lists["USES"])
            self.by_name[name] = layer
            self.declared_in.setdefault(folder, []).append(layer)
            for source in (s for s in lists["SOURCES"] if "$" not in s):
                self.by_source[f"{folder}/{source}"] = layer
        for sources in PROGRAM.findall(text):
            self.programs.update(f"{folder}/{source}" for source in sources.split())

    def is_program(self, path):
        return re.sub(r"\.h$", ".cpp", path) in self.programs

    def of(self, path):
        """A source's own layer; a header's is that of its source. A header without one belongs to
        the lowest layer of its folder; if several are the lowest, they share it, and any layer
        above may see it too: there is nothing to link."""
        source = re.sub(r"(-inl)?\.h$", ".cpp", path)
        if source in self.by_source:
            return self.by_source[source]
        if path.endswith(".cpp") or self.is_program(path):
            return None
        folder = path.rpartition("/")[0]
        near = [layer for file, layer in self.by_source.items() if file.rpartition("/")[0] == folder]
        while not near and folder:
            near = self.declared_in.get(folder, [])
            folder = folder.rpartition("/")[0]
        if not near:
            return None
        lowest = min(layer.rank for layer in near)
        near = sorted({layer.name for layer in near if layer.rank == lowest})
        if len(near) == 1:
            return self.by_name[near[0]]
        uses = set.union(*(set(self.by_name[name].uses) for name in near))
        return Layer("/".join(near), lowest - 0.5, uses, shared=True)

    def seen_from(self, layer):
        seen, todo = {layer.name}, list(layer.uses)
        while todo:
            name = todo.pop()
            if name not in seen and name in self.by_name:
                seen.add(name)
                todo += self.by_name[name].uses
        return seen


def breach_of_project_include(layers, path, target):
    """Why the file `path` may not include the project's file `target`; None if it may."""
    side, target_side = path.split("/")[0], target.split("/")[0]
    if target_side not in SIDES:
        return "project headers are included by their path from the root"
    if side == "core" and target_side != "core" or side == "protocol" and target_side != "protocol":
        return f"{side} knows nothing of {target_side}"
    if layers.is_program(path):
        return None
    own, other = layers.of(path), layers.of(target)
    if other is None:
        return f"{target} belongs to no layer"
    if other.shared and other.rank < own.rank or own.name == other.name:
        return None
    if other.name not in layers.seen_from(own):
        return (f"{own.name} (rank {own.rank:g}) does not use {other.name} (rank {other.rank:g}), "
                "see flare_layer()")
    return None


def breach_of_library(path, header):
    for name, headers, allowed in LIBRARIES:
        if re.match(headers, header) and not re.match(allowed, path):
            return f"{name} is for {allowed} only"
    if path.startswith("core/") and OUTSIDE_WORLD.match(header):
        return f"the core does not see <{header}>: bytes in, bytes out"
    return None


def breaches_of_file(root, layers, path):
    found = []
    if not layers.is_program(path) and layers.of(path) is None:
        return [(path, 1, "belongs to no flare_layer() and no program")]
    core_line = wire_line = None
    for number, line in enumerate((root / path).read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        quote, target = match.groups()
        why = breach_of_library(path, target)
        if quote == '"' and not why:
            why = breach_of_project_include(layers, path, target)
        core_line = number if CORE_TYPE.match(target) else core_line
        wire_line = number if WIRE.match(target) else wire_line
        if why:
            found.append((path, number, why))
    if core_line and wire_line and not TRANSLATORS.match(path):
        why = "sees a wire type and a core type: that is server/translate's work"
        found.append((path, max(core_line, wire_line), why))
    return found


def check(root):
    """All breaches under `root` as (path, line, reason), and the number of files looked at."""
    layers = Layers(root)
    found, count = [], 0
    for side in SIDES:
        for file in sorted((root / side).rglob("*")):
            if file.suffix in (".h", ".cpp"):
                count += 1
                found += breaches_of_file(root, layers, file.relative_to(root).as_posix())
    return found, count


def main():
    here = pathlib.Path(__file__).resolve().parent.parent
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here
    found, count = check(root)
    for path, line, why in found:
        print(f"{path}:{line}: {why}")
    if count == 0:
        print(f"no sources under {root}")
        return 1
    print(f"{count} files, {len(found)} breaches of the layers")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
