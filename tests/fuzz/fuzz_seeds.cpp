// SPDX-License-Identifier: Apache-2.0
//
// Writes what the fuzzers start from: sound lens files of every format, requests with every field,
// and bytes of noise for pictures.
//
//   fuzz_seeds FOLDER    fills FOLDER/lens_file, lens_import, request and render
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/prescription/prescription_writer.h"
#include "tests/support/foreign_lens_files.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

namespace fs = std::filesystem;

void Write(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
}

std::string FileText(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

// The least that is a lens: most of the time goes into reading characters, so that a short file is
// changed in more ways a second.
Prescription ShortLens() {
    return testing::Assemble(
        "s",
        {testing::Sphere(50.0, 4.0, 1.6, 50.0, 9.0), testing::Sphere(-80.0, 2.0, 1.0, 0.0, 9.0),
         testing::Stop(2.0, 5.0), testing::Sphere(90.0, 3.0, 1.5, 60.0, 8.0),
         testing::Sphere(-60.0, 0.0, 1.0, 0.0, 8.0)});
}

void WriteLensFiles(const fs::path& folder) {
    Write(folder / "lens_file" / "short", TomlFromPrescription(ShortLens()));
    for (const fs::directory_entry& file : fs::directory_iterator(FLARE_SOURCE_DIR "/lenses")) {
        if (file.path().extension() != ".toml" || file.file_size() > 8'000) continue;
        Write(folder / "lens_file" / file.path().filename(), FileText(file.path()));
    }
}

void WriteForeignFiles(const fs::path& folder) {
    const Prescription lens = testing::LibraryPrescription(testing::kHeliarName);
    const Prescription few = ShortLens();
    char number = 0;
    for (const testing::ForeignFormat& format : testing::ForeignFormats()) {
        const std::string text = format.write(lens);
        const std::string name = format.name;
        Write(folder / "lens_import" / (name + "_short"),
              std::string(1, number) + format.write(few));
        Write(folder / "lens_import" / name, std::string(1, number++) + text);
        Write(folder / "lens_import" / (name + "_unnamed"), '\xff' + text);
    }
}

void WriteRequests(const fs::path& folder) {
    const char* const requests[] = {
        R"({"lens":"textbook-heliar-100mm-f5","image":{"width":64,"height":36},"lights":[]})",
        R"({"lens":"tronnier-double-gauss-50mm-f2","f_number":4.0,"focus_m":null,"zoom_mm":null,
"iris":{"blades":6,"roundness":0.2,"rotation_deg":10,"irregularity":0.1,"seed":7},
"image":{"width":64,"height":36,"sensor_width_mm":36.0,"crop":[1,2,30,20],"center_offset_mm":[1,2],
"pixel_aspect":1.5,"projection":"lens"},
"lights":[{"direction":[0.087,0.05,0.995],"irradiance":[1,1,1],"angular_diameter_deg":0.53},
{"pixel":[40,30],"distance_m":2.5,"irradiance":[3,2,1],"temperature_k":3200}],
"layers":["ghosts","starburst"],"units":"scene_linear","color_space":"acescg",
"model":{"reflections":4,"ringing":"off","sensor_reflection":false},
"quality":{"preset":"preview"},"output":{"compression":"none","pixel":"float"}})",
        R"({"prescription":{"name":"p","surface":[{"kind":"sphere","radius_mm":50,"gap_mm":5,
"nd":1.5,"vd":60,"semi_diameter_mm":10},{"kind":"stop","gap_mm":1,"nd":1.5,"semi_diameter_mm":5},
{"kind":"sphere","radius_mm":-50,"semi_diameter_mm":10}]},"focus_m":2.0,
"image":{"width":8,"height":8,"overscan":[1,1,2,2]},"lights":[{"direction":[0,0,1],
"irradiance":2}],"color_space":"spectral","wavelengths_nm":[500,600.5],"coatings":"none",
"units":"sensor_irradiance","quality":{"max_error":0.02}})",
        R"({"lens":"canon-zoom-70-200mm-f2_8","zoom_mm":100,"image":{"width":9,"height":9},
"lights":[{"direction":[0.1,0,1]}],"quality":{"preset":"reference","method":"photon",
"samples":1000,"seed":3},"split":"ghost","starburst":{"core":false}})",
        R"({"lens":"nikon-24mm-f2_8","image":{"width":9,"height":9},"lights":[{"direction":[0,0,1],
"spectrum":{"wavelengths_nm":[400,700],"values":[1,2]}}],"quality":{"time_budget_ms":40},
"ghosts":[{"sequence":[3,1],"gain":2,"tint":[1,0,0]},{"sequence":[5,2],"mute":true}]})",
    };
    int number = 0;
    for (const char* request : requests) {
        Write(folder / "request" / std::to_string(number++), request);
    }
}

void WriteNoise(const fs::path& folder) {
    testing::Random random(8);
    for (int file = 0; file < 60; ++file) {
        std::string bytes;
        for (int n = 40 + random.Below(120); n > 0; --n) {
            bytes += static_cast<char>(random.Below(256));
        }
        Write(folder / "render" / std::to_string(file), bytes);
    }
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: fuzz_seeds FOLDER\n");
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    flare::WriteLensFiles(folder);
    flare::WriteForeignFiles(folder);
    flare::WriteRequests(folder);
    flare::WriteNoise(folder);
    return 0;
}
