// SPDX-License-Identifier: Apache-2.0
//
// What the subcommands share: files and standard streams as bytes, lenses by name or path, errors
// as lines on standard error.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/optics/lens.h"
#include "server/lens_library.h"

namespace flare::cli {

// The bytes of a file, or of standard input for "-".
Result<std::string> ReadInput(const std::string& path);
// Writes a file, or standard output for "-".
std::optional<Error> WriteOutput(const std::string& path, std::string_view bytes);

// "flare: FILE: WHERE: MESSAGE [CODE]" on standard error; returns the exit code that fits.
int Complain(const std::string& file, const Error& error);

// The library of `directory` ("" for the program's own); names may be paths.
Result<LensLibrary> OpenLibrary(const std::string& directory);
// One lens by name or path. A path needs no library.
Result<std::shared_ptr<const Lens>> FindLens(const std::string& name, const std::string& directory);

int ThreadsOfThisMachine();
// Milliseconds of a monotonic clock.
double NowMs();

// Prints `text` to standard output and returns the exit code.
int Print(std::string_view text);

}  // namespace flare::cli
