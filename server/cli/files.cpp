// SPDX-License-Identifier: Apache-2.0
#include "server/cli/files.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>

#include "server/cli/app.h"

namespace flare::cli {
namespace {

Error FileError(const char* code, const std::string& path) {
    return {code, path + ": " + std::strerror(errno), ""};
}

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using OwnedFile = std::unique_ptr<std::FILE, CloseFile>;

std::optional<Error> Write(std::FILE* file, const std::string& path, std::string_view bytes) {
    const bool written =
        std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() && std::fflush(file) == 0;
    if (written) return std::nullopt;
    return FileError("cannot_write", path);
}

}  // namespace

Result<std::string> ReadInput(const std::string& path) {
    const bool standard = path == "-";
    const OwnedFile owned(standard ? nullptr : std::fopen(path.c_str(), "rb"));
    if (!standard && !owned) return FileError("bad_file", path);
    std::FILE* file = standard ? stdin : owned.get();
    std::string bytes;
    char buffer[1 << 16];
    while (const std::size_t size = std::fread(buffer, 1, sizeof buffer, file)) {
        bytes.append(buffer, size);
    }
    if (std::ferror(file)) return FileError("bad_file", path);
    return bytes;
}

std::optional<Error> WriteOutput(const std::string& path, std::string_view bytes) {
    if (path == "-") return Write(stdout, "standard output", bytes);
    OwnedFile file(std::fopen(path.c_str(), "wb"));
    if (!file) return FileError("cannot_write", path);
    if (std::optional<Error> error = Write(file.get(), path, bytes)) return error;
    if (std::fclose(file.release()) != 0) return FileError("cannot_write", path);
    return std::nullopt;
}

int Complain(const std::string& file, const Error& error) {
    std::string line = "flare: ";
    if (!file.empty()) line += file + ": ";
    if (!error.where.empty()) line += error.where + ": ";
    line += error.message + " [" + error.code + "]\n";
    std::fputs(line.c_str(), stderr);
    const bool ours =
        error.code == "cancelled" || error.code == "cannot_write" || error.code == "internal";
    return ours ? kFailed : kBadInput;
}

Result<LensLibrary> OpenLibrary(const std::string& directory) {
    Result<LensLibrary> library =
        LensLibrary::Load(directory.empty() ? DefaultLensDirectory() : directory);
    if (library) library->AllowPaths();
    return library;
}

Result<std::shared_ptr<const Lens>> FindLens(const std::string& name,
                                             const std::string& directory) {
    if (LensLibrary::IsPath(name)) {
        LensLibrary files;
        files.AllowPaths();
        return files.Find(name);
    }
    const Result<LensLibrary> library = OpenLibrary(directory);
    if (!library) return library.error();
    return library->Find(name);
}

int ThreadsOfThisMachine() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

double NowMs() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double, std::milli>(now).count();
}

int Print(std::string_view text) {
    if (const std::optional<Error> error = WriteOutput("-", text)) return Complain("", *error);
    return kDone;
}

}  // namespace flare::cli
