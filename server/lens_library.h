// SPDX-License-Identifier: Apache-2.0
//
// The lenses of a folder, by name. Files are read at construction; a file that cannot be built
// keeps its error, so that a request for it can say why. Immutable afterwards, so safe from any
// thread.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/optics/lens.h"

namespace flare {

class LensLibrary {
  public:
    // Error code "bad_library" if the folder cannot be read.
    static Result<LensLibrary> Load(const std::string& directory);

    // From now on a name with a slash or the ending ".toml" is the path of a lens file. For
    // programs that act for the one who names the lens; a service must not read the files its
    // clients name.
    void AllowPaths() { paths_allowed_ = true; }
    static bool IsPath(const std::string& name);

    // Code "unknown_lens" (with near names in the message) or the lens file's own error, its place
    // put into the message.
    Result<std::shared_ptr<const Lens>> Find(const std::string& name) const;
    // Names of the lenses that can be used, sorted.
    std::vector<std::string> Names() const;
    // Files that could not be built: name -> error.
    const std::map<std::string, Error>& broken() const { return broken_; }

  private:
    std::map<std::string, std::shared_ptr<const Lens>> lenses_;
    std::map<std::string, Error> broken_;
    bool paths_allowed_ = false;
};

// Reads, checks and builds one lens file.
Result<std::shared_ptr<const Lens>> LoadLensFile(const std::string& path);

// The library that belongs to this program: $FLARE_LENSES, the source tree's lenses/ in a build,
// the share folder when installed.
std::string DefaultLensDirectory();

}  // namespace flare
