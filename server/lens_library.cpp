// SPDX-License-Identifier: Apache-2.0
#include "server/lens_library.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>

#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"

namespace flare {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxLensFileBytes = 1 << 20;

Result<std::string> ReadLensText(const std::string& path) {
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (failed || !fs::is_regular_file(status)) {
        return Error{"bad_file", "there is no such file", ""};
    }
    if (fs::file_size(path, failed) > kMaxLensFileBytes || failed) {
        return Error{"bad_lens", "a lens file holds at most 1 MiB", ""};
    }
    std::ifstream file(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file) return Error{"bad_file", "the file cannot be read", ""};
    return text;
}

// Edits (insert, delete, replace one character) that turn one word into the other.
std::size_t EditDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row.back();
}

// Up to three names that the writer of `name` may have meant, nearest first.
std::vector<std::string> NearNames(const std::string& name, const std::vector<std::string>& all) {
    std::vector<std::pair<std::size_t, std::string>> ranked;
    for (const std::string& candidate : all) {
        const bool part = name.size() >= 3 && candidate.find(name) != std::string::npos;
        const std::size_t distance = part ? 0 : EditDistance(name, candidate);
        if (distance <= std::max(name.size(), candidate.size()) / 3) {
            ranked.emplace_back(distance, candidate);
        }
    }
    std::sort(ranked.begin(), ranked.end());
    std::vector<std::string> near;
    for (std::size_t i = 0; i < std::min<std::size_t>(3, ranked.size()); ++i) {
        near.push_back(ranked[i].second);
    }
    return near;
}

// For a caller that knows the lens by name only: the place in its file becomes part of the message.
Error OfFile(const std::string& file, const Error& error) {
    const std::string place = error.where.empty() ? "" : error.where + ": ";
    return {error.code, file + ": " + place + error.message, ""};
}

}  // namespace

Result<std::shared_ptr<const Lens>> LoadLensFile(const std::string& path) {
    const Result<std::string> text = ReadLensText(path);
    if (!text) return text.error();
    const Result<Prescription> prescription = ReadPrescriptionToml(*text);
    if (!prescription) return prescription.error();
    for (const Finding& finding : CheckPrescription(*prescription)) {
        if (finding.severity == Severity::kError) {
            return Error{"bad_lens", finding.message, finding.where};
        }
    }
    return Lens::Build(*prescription);
}

Result<LensLibrary> LensLibrary::Load(const std::string& directory) {
    std::error_code failed;
    fs::directory_iterator files(directory, failed);
    if (failed) {
        return Error{"bad_library",
                     "the lens folder " + directory + " cannot be read: " + failed.message(), ""};
    }
    LensLibrary library;
    for (; !failed && files != fs::directory_iterator(); files.increment(failed)) {
        const fs::path& path = files->path();
        if (path.extension() != ".toml") continue;
        const std::string name = path.stem().string();
        Result<std::shared_ptr<const Lens>> lens = LoadLensFile(path.string());
        if (!lens) {
            library.broken_.emplace(name, lens.error());
        } else if ((*lens)->name() != name) {
            library.broken_.emplace(
                name, Error{"bad_lens",
                            "the lens is named \"" + (*lens)->name() + "\" but its file is " +
                                path.filename().string(),
                            ""});
        } else {
            library.lenses_.emplace(name, *lens);
        }
    }
    if (failed) {
        return Error{"bad_library",
                     "the lens folder " + directory + " cannot be read: " + failed.message(), ""};
    }
    return library;
}

bool LensLibrary::IsPath(const std::string& name) {
    return name.find('/') != std::string::npos || name.ends_with(".toml");
}

Result<std::shared_ptr<const Lens>> LensLibrary::Find(const std::string& name) const {
    if (const auto found = lenses_.find(name); found != lenses_.end()) return found->second;
    if (const auto found = broken_.find(name); found != broken_.end()) {
        return OfFile(name + ".toml", found->second);
    }
    if (paths_allowed_ && IsPath(name)) {
        const Result<std::shared_ptr<const Lens>> lens = LoadLensFile(name);
        if (!lens) return OfFile(name, lens.error());
        return lens;
    }
    std::string message = "there is no lens \"" + name + "\"";
    std::string separator = "; near it: ";
    for (const std::string& near : NearNames(name, Names())) {
        message += separator + near;
        separator = ", ";
    }
    return Error{"unknown_lens", message, ""};
}

std::vector<std::string> LensLibrary::Names() const {
    std::vector<std::string> names;
    for (const auto& [name, lens] : lenses_) names.push_back(name);
    return names;
}

std::string DefaultLensDirectory() {
    if (const char* chosen = std::getenv("FLARE_LENSES"); chosen && *chosen) return chosen;
    std::error_code failed;
    const fs::path program = fs::read_symlink("/proc/self/exe", failed);
    if (!failed) {
        const fs::path shared = program.parent_path().parent_path() / "share/flared/lenses";
        if (fs::is_directory(shared, failed)) return shared.string();
    }
    return FLARE_SOURCE_LENSES;
}

}  // namespace flare
