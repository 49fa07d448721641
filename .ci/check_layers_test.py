# SPDX-License-Identifier: Apache-2.0
"""The layer check finds what it is there to find. Run: python3 -m unittest discover -s .ci -p '*_test.py'"""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check_layers  # noqa: E402

CMAKE = {
    "core/base": "flare_layer(base 1\n    SOURCES check.cpp)",
    "core/optics": "# a comment (with brackets)\n"
                   "flare_layer(optics 2 SOURCES lens.cpp glass.cpp USES base)",
    "core/prescription": "flare_layer(prescription 3 SOURCES toml_document.cpp prescription_reader.cpp\n"
                         "    USES base optics)",
    "core/spectrum": "flare_layer(spectrum 2 SOURCES spectrum.cpp USES base)",
    "core/tracing": "flare_layer(tracing 3 SOURCES trace.cpp USES base optics)",
    "core/image": "flare_layer(image 5 SOURCES raster.cpp USES tracing)\n"
                  "flare_layer(exr 5 SOURCES exr.cpp exr_decode.cpp USES base PRIVATE OpenEXR::OpenEXR)\n"
                  "flare_layer(preview 5 SOURCES preview.cpp USES base)",
    "core/render": "flare_layer(render 6 SOURCES renderer.cpp USES image)",
    "protocol": "flare_layer(protocol 1 SOURCES codec/json.cpp PRIVATE nlohmann_json)\n"
                "flare_layer(openapi 1 SOURCES ${generated})",
    "protocol/client": "flare_layer(client 2 SOURCES client.cpp)",
    "server": "flare_layer(translate 8 SOURCES translate/request.cpp USES render protocol)\n"
              "flare_layer(service 9 SOURCES service.cpp USES translate exr)\n"
              "flare_layer(schedule 9 SOURCES schedule/queue.cpp USES base)\n"
              "flare_layer(http 10 SOURCES http/listener.cpp USES service schedule)\n"
              "add_executable(flared flared.cpp signals.cpp)",
}

# (file, include lines, whether it is allowed)
CASES = [
    ("core/tracing/trace.cpp", '#include "core/optics/lens.h"', True),
    ("core/tracing/trace.h", '#include "core/tracing/ray_fate.h"', True),
    ("core/tracing/ray_fate.h", '#include "core/optics/lens.h"', True),
    ("core/optics/lens.h", '#include "core/tracing/trace.h"', False),
    ("core/optics/lens.h", '#include "core/spectrum/spectrum.h"', False),
    ("core/tracing/trace.cpp", '#include "core/spectrum/spectrum.h"', False),
    ("core/optics/lens.cpp", '#include "core/prescription/prescription_reader.h"', False),
    ("core/optics/lens.cpp", '#include "core/optics/prescription.h"', True),
    ("core/prescription/toml_document.cpp", "#include <toml++/toml.h>", True),
    ("core/optics/lens.cpp", "  #  include <toml++/toml.h>", False),
    ("core/image/preview.cpp", '#include "core/image/flare_image.h"', True),
    ("core/image/preview.cpp", '#include "core/image/exr.h"', False),
    ("core/image/flare_image.h", '#include "core/image/exr.h"', False),
    ("core/image/flare_image.h", '#include "core/tracing/trace.h"', True),
    ("core/image/flare_image.h", '#include "core/render/renderer.h"', False),
    ("core/image/exr_decode.cpp", "#include <OpenEXR/ImfInputFile.h>", True),
    ("core/image/exr.cpp", "#include <OpenEXR/ImfOutputFile.h>", False),
    ("core/render/renderer.cpp", '#include "core/image/flare_image.h"', True),
    ("core/render/renderer.cpp", '#include "core/optics/lens.h"', True),
    ("core/render/renderer.cpp", '#include "core/image/exr.h"', False),
    ("core/render/renderer.cpp", "#include <ImfOutputFile.h>", False),
    ("core/render/renderer.cpp", "#include <fstream>", False),
    ("core/render/renderer.cpp", "#include <vector>", True),
    ("core/render/renderer.cpp", '#include "protocol/limits.h"', False),
    ("core/render/renderer.cpp", '#include "renderer.h"', False),
    ("core/render/orphan.cpp", "", False),
    ("core/lost/a.h", '#include "core/base/check.h"', False),
    ("protocol/codec/json.cpp", '#include "core/base/result.h"', False),
    ("protocol/codec/json.cpp", '#include <nlohmann/json.hpp>\n#include "protocol/wire/x.h"', True),
    ("protocol/client/client.cpp", "#include <boost/beast.hpp>", True),
    ("protocol/client/client.cpp", '#include "protocol/codec/json.h"', False),
    ("server/schedule/queue.cpp", "#include <boost/asio.hpp>", False),
    ("server/schedule/queue.cpp", '#include "server/service.h"', False),
    ("server/http/listener.cpp", '#include "server/service.h"', True),
    ("server/flared.cpp", '#include "server/http/listener.h"', True),
    ("server/signals.h", '#include "server/http/listener.h"', True),
    ("server/http/listener.cpp", '#include "server/signals.h"', False),
    ("server/http/listener.cpp",
     '#include "protocol/wire/x.h"\n#include "core/render/renderer.h"', False),
    ("server/translate/request.cpp",
     '#include "protocol/wire/x.h"\n#include "core/render/renderer.h"', True),
]


def breaches(files):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for side, text in CMAKE.items():
            (root / side).mkdir(parents=True, exist_ok=True)
            (root / side / "CMakeLists.txt").write_text(text, encoding="utf-8")
        for path, text in files.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text, encoding="utf-8")
        return check_layers.check(root)


class CheckLayersTest(unittest.TestCase):
    def test_each_case_is_judged_right(self):
        for path, lines, allowed in CASES:
            with self.subTest(path=path, lines=lines):
                found, count = breaches({path: f"// a file\n{lines}\n"})
                self.assertEqual(count, 1)
                self.assertEqual(found == [], allowed, found)

    def test_a_breach_names_file_and_line(self):
        found, _ = breaches({"core/base/a.h": '\n\n#include "core/render/b.h"\n'})
        self.assertEqual([(path, line) for path, line, _ in found], [("core/base/a.h", 3)])


if __name__ == "__main__":
    unittest.main()
